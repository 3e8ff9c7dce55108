#include "carat/synth/synth.hpp"

#include <algorithm>
#include <memory>
#include <system_error>

#include "carat/globe/error.hpp"
#include "earth.hpp"
#include "geotiff.hpp"
#include "kinds.hpp"
#include "layer.hpp"
#include "manifest.hpp"
#include "moon.hpp"

namespace carat::synth {
namespace {

namespace fs = std::filesystem;

template <typename Relief>
Height shared(std::uint64_t seed, double min_wavelength_m) {
    if (!(min_wavelength_m >= 1))
        throw Error(ErrorCode::usage, "the smallest wavelength must be at least 1 m");
    return [relief = std::make_shared<const Relief>(seed, min_wavelength_m)](const Vec3& n) {
        return (*relief)(n);
    };
}

/// The planet that this thread asked for last.
template <typename Relief>
double at(const Vec3& n, std::uint64_t seed, double min_wavelength_m) {
    struct Last {
        std::uint64_t seed;
        double min_wavelength_m;
        Height height;
    };
    thread_local std::unique_ptr<Last> last;
    if (!last || last->seed != seed || last->min_wavelength_m != min_wavelength_m)
        last = std::make_unique<Last>(seed, min_wavelength_m, shared<Relief>(seed, min_wavelength_m));
    return last->height(n);
}

std::vector<Layer> layers_of(Kind kind, const Options& options) {
    if (kind == Kind::earth) return earth_layers(options);
    if (kind == Kind::moon) return moon_layers(options);
    if (kind == Kind::empty || kind == Kind::truncated) return damaged_layers(kind, options);
    if (kind != Kind::hostile) {
        std::vector<Layer> layers = value_layers(kind, options);
        return layers.empty() ? placement_layers(kind, options) : layers;
    }
    std::vector<Layer> all;
    for (const KindInfo& k : kinds())
        if (k.kind > Kind::moon && k.kind < Kind::hostile)
            for (Layer& l : layers_of(k.kind, options)) all.push_back(std::move(l));
    return all;
}

void check(const Options& options) {
    if (options.size != 0 && (options.size < 2 || options.size > 86400 || options.size % 2 != 0))
        throw Error(ErrorCode::usage, "size must be an even number of columns from 2 to 86400");
    if (options.inset_size != 0 && (options.inset_size < 2 || options.inset_size > 20000))
        throw Error(ErrorCode::usage, "insets must have 2 to 20000 columns");
    if (options.min_wavelength_m != 0 && !(options.min_wavelength_m >= 1))
        throw Error(ErrorCode::usage, "the smallest wavelength must be at least 1 m");
}

void refuse_existing(const std::vector<Layer>& layers, const fs::path& directory) {
    const auto refuse = [&](const std::string& name) {
        if (fs::exists(directory / name))
            throw Error(ErrorCode::usage, (directory / name).string() + " exists already");
    };
    for (const Layer& l : layers) refuse(l.info.name);
    refuse(kManifestName);
}

std::vector<Written> write_layers(Kind kind, const std::vector<Layer>& layers, const fs::path& directory,
                                  const Options& options) {
    std::uint64_t done = 0, total = 0;
    for (const Layer& l : layers)
        total += static_cast<std::uint64_t>(l.grid.width) * static_cast<std::uint64_t>(l.grid.height);
    const auto advance = [&](std::uint64_t samples) {
        done += samples;
        if (options.progress && !options.progress(done, total))
            throw Error(ErrorCode::io,
                        directory.string() + ": interrupted; the files named so far are complete");
    };
    std::vector<Written> written;
    for (const Layer& l : layers) {
        write_geotiff(l, directory, advance);
        written.push_back(l.info);
    }
    write_manifest(kind, options, written, directory);
    return written;
}

}  // namespace

Height earthlike(std::uint64_t seed, double min_wavelength_m) {
    return shared<EarthRelief>(seed, min_wavelength_m);
}
Height moonlike(std::uint64_t seed, double min_wavelength_m) {
    return shared<MoonRelief>(seed, min_wavelength_m);
}

double earthlike_height(const std::array<double, 3>& n, std::uint64_t seed, double min_wavelength_m) {
    return at<EarthRelief>(n, seed, min_wavelength_m);
}
double moonlike_height(const std::array<double, 3>& n, std::uint64_t seed, double min_wavelength_m) {
    return at<MoonRelief>(n, seed, min_wavelength_m);
}

Planet planet(Kind kind, const Options& options) {
    check(options);
    const double finest = options.min_wavelength_m > 0 ? options.min_wavelength_m : kFinestWavelength;
    const char* name = info_of(kind).name;
    if (kind == Kind::hostile)
        throw Error(ErrorCode::usage, "the kind 'hostile' is many planets: name one of them");
    if (kind == Kind::earth) return {name, body_of(kind), earthlike(options.seed, finest)};
    if (kind == Kind::moon) return {name, body_of(kind), moonlike(options.seed, finest)};
    return {name, body_of(kind), layers_of(kind, options).front().info.truth};
}

std::vector<Written> write(Kind kind, const fs::path& directory, const Options& options) {
    check(options);
    try {
        const std::vector<Layer> layers = layers_of(kind, options);
        fs::create_directories(directory);
        if (!options.overwrite) refuse_existing(layers, directory);
        return write_layers(kind, layers, directory, options);
    } catch (const fs::filesystem_error& e) {
        throw Error(ErrorCode::io, e.path1().string() + ": " + e.code().message());
    }
}

}  // namespace carat::synth
