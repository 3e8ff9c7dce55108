#include "values.hpp"

#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>

#include "carat/globe/error.hpp"

namespace carat::cli {
namespace {

[[noreturn]] void refuse(const std::string& text, const std::string& wanted) {
    throw CLI::ValidationError("\"" + text + "\" is not " + wanted);
}

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> out(1);
    for (const char c : text)
        if (c == separator)
            out.emplace_back();
        else
            out.back() += c;
    return out;
}

// A number at the front of the text; what follows it goes to `rest`.
std::optional<double> leading_number(const std::string& text, std::string& rest) {
    const char* begin = text.data();
    const char* const end = begin + text.size();
    if (begin != end && *begin == '+') ++begin;
    double value = 0;
    const auto [at, error] = std::from_chars(begin, end, value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    rest.assign(at, end);
    return value;
}

}  // namespace

double parse_number(const std::string& text) {
    std::string rest;
    const std::optional<double> value = leading_number(text, rest);
    if (!value || !rest.empty()) refuse(text, "a number");
    return *value;
}

std::vector<double> parse_numbers(const std::string& text, std::size_t count) {
    const std::vector<std::string> parts = split(text, ',');
    if (parts.size() != count) refuse(text, std::to_string(count) + " numbers separated by commas");
    std::vector<double> out;
    for (const std::string& part : parts) out.push_back(parse_number(part));
    return out;
}

std::size_t parse_size(const std::string& text) {
    std::string unit;
    const std::optional<double> value = leading_number(text, unit);
    static const std::string kPrefixes = "KMGT";
    double factor = 1;
    if (!unit.empty()) {
        const auto power =
            kPrefixes.find(static_cast<char>(std::toupper(static_cast<unsigned char>(unit[0]))));
        const std::string tail = unit.substr(1);
        if (power != std::string::npos && (tail.empty() || tail == "B" || tail == "iB"))
            factor = std::ldexp(1.0, 10 * static_cast<int>(power + 1));
        else if (unit != "B")
            refuse(text, "a size such as 512M or 1G");
    }
    if (!value || !(*value * factor >= 1) || *value * factor > 0x1p62)
        refuse(text, "a size such as 512M or 1G");
    return static_cast<std::size_t>(*value * factor);
}

std::array<int, 2> parse_picture_size(const std::string& text) {
    constexpr double kGreatest = 65536;
    const std::vector<std::string> parts = split(text, 'x');
    if (parts.size() != 2) refuse(text, "a picture size such as 1280x720");
    std::array<int, 2> out{};
    for (std::size_t k = 0; k < 2; ++k) {
        const double value = parse_number(parts[k]);
        if (value != std::floor(value) || value < 1 || value > kGreatest)
            refuse(text, "a picture size of 1 to 65536 pixels a side");
        out[k] = static_cast<int>(value);
    }
    return out;
}

std::vector<std::array<int, 2>> parse_picture_sizes(const std::string& text) {
    std::vector<std::array<int, 2>> out;
    for (const std::string& part : split(text, ',')) out.push_back(parse_picture_size(part));
    return out;
}

std::vector<std::string> parse_files(const std::string& text) {
    std::error_code too_long;  // for a name: then it is a list
    if (std::filesystem::exists(text, too_long)) return {text};
    const std::vector<std::string> parts = split(text, ',');
    for (const std::string& part : parts)
        if (part.empty()) refuse(text, "a list of files separated by commas");
    return parts;
}

CLI::Option* add_value(CLI::App& app, const std::string& name, const std::string& form,
                       const std::string& description, std::function<void(const std::string&)> take) {
    const auto named = [name, take = std::move(take)](const std::string& text) {
        try {
            take(text);
        } catch (const CLI::ValidationError& error) {
            throw CLI::ValidationError(name, error.what());
        } catch (const Error& error) {
            throw CLI::ValidationError(name, error.what());
        }
    };
    return app.add_option_function<std::string>(name, named, description)->type_name(form);
}

CLI::Option* add_place(CLI::App& app, const std::string& description,
                       std::function<void(const Geodetic&)> take) {
    return add_value(app, "--at", "LAT,LON", description, [take = std::move(take)](const std::string& text) {
        const std::vector<double> v = parse_numbers(text, 2);
        take({v[0], v[1]});
    });
}

}  // namespace carat::cli
