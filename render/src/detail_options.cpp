#include <charconv>
#include <cmath>
#include <sstream>

#include "carat/globe/error.hpp"
#include "carat/render/detail.hpp"

namespace carat {
namespace {

template <class Number>
Number number(const std::string& name, const std::string& text) {
    Number out{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(static_cast<double>(out)))
        throw Error(ErrorCode::usage, "--detail: " + name + "=" + text + " is not a number");
    return out;
}

void set(DetailOptions& o, const std::string& name, const std::string& value) {
    if (name == "seed")
        o.seed = number<std::uint64_t>(name, value);
    else if (name == "amplitude")
        o.amplitude = number<double>(name, value);
    else if (name == "to")
        o.to = number<double>(name, value);
    else if (name == "slope")
        o.slope = number<double>(name, value);
    else if (name == "mode" && (value == "natural" || value == "uniform"))
        o.uniform = value == "uniform";
    else
        throw Error(ErrorCode::usage, "--detail: \"" + name + "=" + value +
                                          "\" is none of seed=N, amplitude=X, to=METRES, slope=DEGREES, "
                                          "mode=natural, mode=uniform");
}

}  // namespace

DetailOptions DetailOptions::parse(const std::string& text) {
    DetailOptions out;
    std::istringstream in(text);
    for (std::string item; std::getline(in, item, ',');) {
        const std::size_t at = item.find('=');
        if (at == std::string::npos)
            throw Error(ErrorCode::usage, "--detail: \"" + item + "\" is not NAME=VALUE");
        set(out, item.substr(0, at), item.substr(at + 1));
    }
    return out;
}

}  // namespace carat
