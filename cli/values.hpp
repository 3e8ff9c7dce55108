// Values of options: lists, sizes, picture sizes. Every parser throws CLI::ValidationError that says what is
// wrong with the text; the program then ends with exit code 2.
#pragma once

#include <CLI/App.hpp>
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "carat/globe/ellipsoid.hpp"

namespace carat::cli {

// The whole text as a finite number.
double parse_number(const std::string& text);
// "A,B,C": exactly `count` finite numbers.
std::vector<double> parse_numbers(const std::string& text, std::size_t count);
// "512M", "1.5GiB", "4096": bytes, suffixes K M G T are powers of 1024.
std::size_t parse_size(const std::string& text);
// "1280x720"
std::array<int, 2> parse_picture_size(const std::string& text);
// "96x72,128x128": one or more of them.
std::vector<std::array<int, 2>> parse_picture_sizes(const std::string& text);
// Names separated by commas; none may be empty. If the whole text is an existing file, it is one name.
std::vector<std::string> parse_files(const std::string& text);

// A check of the range of a number that leaves the help alone.
template <class T>
CLI::Validator between(T least, T greatest) {
    return CLI::Range(least, greatest).description("");
}

// An option with one value of a given form; what `take` throws gets the option's name.
CLI::Option* add_value(CLI::App& app, const std::string& name, const std::string& form,
                       const std::string& description, std::function<void(const std::string&)> take);

// An option "--at LAT,LON", degrees.
CLI::Option* add_place(CLI::App& app, const std::string& description,
                       std::function<void(const Geodetic&)> take);

// An option "--name A,B,C" of exactly N numbers, which may be negative.
template <std::size_t N>
CLI::Option* add_numbers(CLI::App& app, const std::string& name, std::array<double, N>& out,
                         const std::string& form, const std::string& description) {
    return add_value(app, name, form, description, [&out](const std::string& text) {
        const std::vector<double> values = parse_numbers(text, N);
        std::copy(values.begin(), values.end(), out.begin());
    });
}

}  // namespace carat::cli
