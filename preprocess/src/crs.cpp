#include "crs.hpp"

#include <ogr_spatialref.h>
#include <proj.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "carat/globe/error.hpp"
#include "gdal_errors.hpp"
#include "pool.hpp"

namespace carat {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// --- PROJ's objects, owned ---

struct ContextDeleter {
    void operator()(PJ_CONTEXT* c) const { proj_context_destroy(c); }
};
struct PjDeleter {
    void operator()(PJ* p) const { proj_destroy(p); }
};
using Context = std::unique_ptr<PJ_CONTEXT, ContextDeleter>;
using Pj = std::unique_ptr<PJ, PjDeleter>;

Context make_context() {
    Context context(proj_context_create());
    proj_log_level(context.get(), PJ_LOG_NONE);
    return context;
}

// A transformation with the context it lives in: what one thread may use.
struct Transformer {
    Context context;
    Pj pj;
};

// longitude, latitude in degrees -> x, y of the raster's CRS, one operation for every place.
class Transformation {
  public:
    explicit Transformation(Transformer original)
        : original_(std::move(original)), pool_([this] { return copy(); }) {}

    void apply(PJ_DIRECTION direction, std::span<double> x, std::span<double> y) const {
        const auto t = pool_.borrow();
        proj_trans_generic(t->pj.get(), direction, x.data(), sizeof(double), x.size(), y.data(),
                           sizeof(double), y.size(), nullptr, 0, 0, nullptr, 0, 0);
    }

  private:
    std::unique_ptr<Transformer> copy() const {
        auto t = std::make_unique<Transformer>(Transformer{make_context(), nullptr});
        t->pj.reset(proj_clone(t->context.get(), original_.pj.get()));
        if (!t->pj) throw Error(ErrorCode::io, "PROJ cannot copy a coordinate transformation");
        return t;
    }

    Transformer original_;
    mutable Pool<Transformer> pool_;
};

// --- geographic on the body's own datum ---

class PlainCrs final : public Crs {
  public:
    PlainCrs() { turn_ = 360; }
    void forward(std::span<const double> lat, std::span<const double> lon, std::span<double> x,
                 std::span<double> y) const override {
        std::copy(lon.begin(), lon.end(), x.begin());
        std::copy(lat.begin(), lat.end(), y.begin());
    }
    void inverse(std::span<double>, std::span<double>) const override {}
    bool is_plain() const override { return true; }
};

// --- everything else on the Earth: PROJ from WGS 84 ---

class EarthCrs final : public Crs {
  public:
    EarthCrs(Transformer proj, double turn, std::string transformation) : proj_(std::move(proj)) {
        turn_ = turn;
        transformation_ = std::move(transformation);
    }
    void forward(std::span<const double> lat, std::span<const double> lon, std::span<double> x,
                 std::span<double> y) const override {
        std::copy(lon.begin(), lon.end(), x.begin());
        std::copy(lat.begin(), lat.end(), y.begin());
        proj_.apply(PJ_FWD, x, y);
    }
    void inverse(std::span<double> x, std::span<double> y) const override { proj_.apply(PJ_INV, x, y); }
    bool is_costly() const override { return true; }

  private:
    Transformation proj_;
};

// --- other bodies: the CRS's own latitude and longitude, geodetic or geocentric; then its projection, if any
// ---

class BodyCrs final : public Crs {
  public:
    // unit: degrees per unit of a geographic CRS; meridian: longitude of its prime meridian in degrees.
    BodyCrs(const Ellipsoid& body, bool geocentric, double unit, double meridian)
        : ratio_(geocentric ? body.b() * body.b() / (body.a() * body.a()) : 1),
          unit_(unit),
          meridian_(meridian) {
        turn_ = 360 / unit;
    }
    BodyCrs(const Ellipsoid& body, bool geocentric, double meridian, Transformer projection)
        : BodyCrs(body, geocentric, 1, meridian) {
        turn_ = 0;
        proj_ = std::make_unique<Transformation>(std::move(projection));
    }
    void forward(std::span<const double> lat, std::span<const double> lon, std::span<double> x,
                 std::span<double> y) const override {
        for (std::size_t i = 0; i < lat.size(); ++i) {
            x[i] = (lon[i] - meridian_) / unit_;
            y[i] = scaled(lat[i], ratio_) / unit_;
        }
        if (proj_) proj_->apply(PJ_FWD, x, y);
    }
    void inverse(std::span<double> x, std::span<double> y) const override {
        if (proj_) proj_->apply(PJ_INV, x, y);
        for (std::size_t i = 0; i < x.size(); ++i) {
            x[i] = x[i] * unit_ + meridian_;
            y[i] = scaled(y[i] * unit_, 1 / ratio_);
        }
    }

    bool is_costly() const override { return proj_ != nullptr; }

  private:
    // The latitude whose tangent is `ratio` times that of the given one.
    static double scaled(double latitude, double ratio) {
        if (ratio == 1 || !(std::abs(latitude) < 90)) return latitude;
        return std::atan(ratio * std::tan(latitude * kDegree)) / kDegree;
    }

    double ratio_, unit_, meridian_;
    std::unique_ptr<Transformation> proj_;
};

// --- choosing ---

[[noreturn]] void refuse(const std::string& file, const std::string& why) {
    throw Error(ErrorCode::usage, file + ": " + why);
}

OGRSpatialReference parse(const std::string& wkt, const std::string& file) {
    const GdalErrors errors;
    OGRSpatialReference srs;
    if (srs.importFromWkt(wkt.c_str()) != OGRERR_NONE)
        refuse(file, "its coordinate reference system is not understood: " + errors.text());
    srs.StripVertical();
    srs.DemoteTo2D(nullptr);
    srs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    if (!srs.IsGeographic() && !srs.IsProjected())
        refuse(file, "its coordinate reference system is neither geographic nor projected");
    return srs;
}

std::string to_wkt(const OGRSpatialReference& srs) {
    char* text = nullptr;
    const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
    srs.exportToWkt(&text, options);
    std::string wkt = text != nullptr ? text : "";
    CPLFree(text);
    return wkt;
}

void check_body(const OGRSpatialReference& srs, const Ellipsoid& body, const std::string& file) {
    const double a = srs.GetSemiMajor();
    if (std::abs(a - body.a()) <= 0.01 * body.a()) return;
    refuse(file, "lies on another body: the semi-major axis of its coordinate reference system is " +
                     std::to_string(a) + " m, the planet's " + std::to_string(body.a()) + " m");
}

bool is_wgs84(const OGRSpatialReference& srs) {
    OGRSpatialReference wgs84;
    wgs84.SetWellKnownGeogCS("WGS84");
    const char* const options[] = {"IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES",
                                   "CRITERION=EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS", nullptr};
    return srs.IsGeographic() && srs.IsSameGeogCS(&wgs84, options) != 0 &&
           std::abs(srs.GetAngularUnits() - kDegree) < 1e-12 && srs.GetPrimeMeridian() == 0;
}

bool says_geocentric(const OGRSpatialReference& srs) {
    std::string name;
    for (const char* node : {"PROJCS", "GEOGCS"})
        if (const char* value = srs.GetAttrValue(node)) name += CPLString(value).tolower();
    return name.find("ocentric") != std::string::npos;
}

// PROJ looks the codes up that a CRS names, and crashes (9.1.1) on one that names something else.
void check_code(PJ_CONTEXT* context, const PJ* crs, const std::string& file) {
    const char* authority = proj_get_id_auth_name(crs, 0);
    const char* code = proj_get_id_code(crs, 0);
    if (authority == nullptr || code == nullptr) return;
    const Pj named(proj_create_from_database(context, authority, code, PJ_CATEGORY_CRS, 0, nullptr));
    const PJ_TYPE type = named ? proj_get_type(named.get()) : PJ_TYPE_UNKNOWN;
    const bool same_kind = type == proj_get_type(crs) || (type == PJ_TYPE_GEOGRAPHIC_3D_CRS &&
                                                          proj_get_type(crs) == PJ_TYPE_GEOGRAPHIC_2D_CRS);
    if (same_kind || !named) return;
    refuse(file, std::string("its coordinate reference system claims to be ") + authority + ":" + code +
                     ", which is " + proj_get_name(named.get()));
}

Pj create(PJ_CONTEXT* context, const std::string& definition, const std::string& file) {
    Pj pj(proj_create(context, definition.c_str()));
    if (!pj)
        refuse(file, std::string("PROJ does not understand its coordinate reference system: ") +
                         proj_context_errno_string(context, proj_context_errno(context)));
    check_code(context, pj.get(), file);
    if (const Pj base{proj_crs_get_geodetic_crs(context, pj.get())}) check_code(context, base.get(), file);
    return pj;
}

Pj normalised(PJ_CONTEXT* context, const Pj& operation, const std::string& file) {
    Pj pj(proj_normalize_for_visualization(context, operation.get()));
    if (!pj) refuse(file, "PROJ cannot order the axes of its coordinate reference system");
    return pj;
}

// From the CRS's own geographic base, so without a datum transformation.
Pj own_projection(PJ_CONTEXT* context, const Pj& crs, const std::string& file) {
    const Pj base(proj_crs_get_geodetic_crs(context, crs.get()));
    Pj operation;
    if (base)
        operation.reset(proj_create_crs_to_crs_from_pj(context, base.get(), crs.get(), nullptr, nullptr));
    if (!operation) refuse(file, "PROJ cannot invert its projection");
    return normalised(context, operation, file);
}

// West, south, east, north in degrees of a box, roughly, for choosing among datum transformations.
std::optional<std::array<double, 4>> area_of_use(const Pj& projection, const CrsBox& box) {
    std::array<double, 4> area{360, 90, -360, -90};
    for (int i = 0; i <= 4; ++i)
        for (int j = 0; j <= 4; ++j) {
            const PJ_COORD place = proj_coord(box.min_x + (box.max_x - box.min_x) * i / 4,
                                              box.min_y + (box.max_y - box.min_y) * j / 4, 0, 0);
            const PJ_COORD g = proj_trans(projection.get(), PJ_INV, place);
            if (!std::isfinite(g.xy.x) || !std::isfinite(g.xy.y)) continue;
            area = {std::min(area[0], g.xy.x), std::min(area[1], g.xy.y), std::max(area[2], g.xy.x),
                    std::max(area[3], g.xy.y)};
        }
    if (area[0] > area[2] || area[0] < -180 || area[2] > 180) return std::nullopt;
    return area;
}

struct Operations {
    PJ_OPERATION_FACTORY_CONTEXT* factory;
    PJ_OBJ_LIST* list = nullptr;

    Operations(PJ_CONTEXT* context, const Pj& from, const Pj& to,
               const std::optional<std::array<double, 4>>& area)
        : factory(proj_create_operation_factory_context(context, nullptr)) {
        if (area)
            proj_operation_factory_context_set_area_of_interest(context, factory, (*area)[0], (*area)[1],
                                                                (*area)[2], (*area)[3]);
        proj_operation_factory_context_set_spatial_criterion(context, factory,
                                                             PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
        proj_operation_factory_context_set_grid_availability_use(context, factory,
                                                                 PROJ_GRID_AVAILABILITY_IGNORED);
        list = proj_create_operations(context, from.get(), to.get(), factory);
    }
    ~Operations() {
        proj_list_destroy(list);
        proj_operation_factory_context_destroy(factory);
    }
    Operations(const Operations&) = delete;
    Operations& operator=(const Operations&) = delete;

    int count() const { return list != nullptr ? proj_list_get_count(list) : 0; }
};

std::string missing_grids(PJ_CONTEXT* context, const PJ* operation) {
    std::string names;
    for (int i = 0; i < proj_coordoperation_get_grid_used_count(context, operation); ++i) {
        const char* name = nullptr;
        int available = 0;
        proj_coordoperation_get_grid_used(context, operation, i, &name, nullptr, nullptr, nullptr, nullptr,
                                          nullptr, &available);
        if (available == 0 && name != nullptr) names += (names.empty() ? "" : ", ") + std::string(name);
    }
    return names.empty() ? "a grid" : names;
}

std::string accuracy(PJ_CONTEXT* context, const PJ* operation) {
    const double metres = proj_coordoperation_get_accuracy(context, operation);
    if (metres < 0) return "unknown accuracy";
    return "accuracy " + CPLString().Printf("%g", metres) + " m";
}

// The best operation that can be carried out here; warns if a better one lacks its grid.
Pj best_operation(PJ_CONTEXT* context, const Operations& operations, const std::string& file,
                  std::vector<std::string>& warnings) {
    for (int i = 0; i < operations.count(); ++i) {
        Pj operation(proj_list_get(context, operations.list, i));
        if (proj_coordoperation_is_instantiable(context, operation.get()) == 0) continue;
        const std::string name = proj_get_name(operation.get());
        if (i > 0) {
            const Pj better(proj_list_get(context, operations.list, 0));
            warnings.push_back(file + ": the most accurate transformation to WGS 84, " +
                               proj_get_name(better.get()) + " (" + accuracy(context, better.get()) +
                               "), needs " + missing_grids(context, better.get()) +
                               ", which PROJ does not have; using " + name + " (" +
                               accuracy(context, operation.get()) + ")");
        } else if (proj_coordoperation_has_ballpark_transformation(context, operation.get()) != 0) {
            warnings.push_back(file +
                               ": PROJ knows no transformation of its datum to WGS 84; its coordinates are "
                               "taken as they are");
        }
        return operation;
    }
    refuse(file, "PROJ knows no transformation of its coordinate reference system to WGS 84");
}

std::shared_ptr<const Crs> earth_crs(const OGRSpatialReference& srs, const CrsBox& box,
                                     const std::string& file, std::vector<std::string>& warnings) {
    Context context = make_context();
    const Pj crs = create(context.get(), to_wkt(srs), file);
    const Pj wgs84 = create(context.get(), "OGC:CRS84", file);
    const auto area = area_of_use(own_projection(context.get(), crs, file), box);
    const Pj best = best_operation(context.get(), {context.get(), wgs84, crs, area}, file, warnings);
    const double turn = srs.IsGeographic() ? 2 * std::numbers::pi / srs.GetAngularUnits() : 0;
    const std::string name = proj_get_name(best.get());
    Pj pj = normalised(context.get(), best, file);
    return std::make_shared<EarthCrs>(Transformer{std::move(context), std::move(pj)}, turn, name);
}

std::shared_ptr<const Crs> body_crs(const OGRSpatialReference& srs, const Ellipsoid& body,
                                    LatitudeKind latitude, const std::string& file) {
    const bool geocentric =
        latitude == LatitudeKind::geocentric || (latitude == LatitudeKind::automatic && says_geocentric(srs));
    const double meridian = srs.GetPrimeMeridian();
    if (srs.IsGeographic()) {
        const double unit = srs.GetAngularUnits() / kDegree;
        if (!geocentric && std::abs(unit - 1) < 1e-12 && meridian == 0) return Crs::plain();
        return std::make_shared<BodyCrs>(body, geocentric, unit, meridian);
    }
    Context context = make_context();
    const Pj crs = create(context.get(), to_wkt(srs), file);
    Pj projection = own_projection(context.get(), crs, file);
    return std::make_shared<BodyCrs>(body, geocentric, meridian,
                                     Transformer{std::move(context), std::move(projection)});
}

}  // namespace

std::shared_ptr<const Crs> Crs::plain() {
    static const std::shared_ptr<const Crs> crs = std::make_shared<PlainCrs>();
    return crs;
}

std::shared_ptr<const Crs> Crs::of_wkt(const std::string& wkt, const CrsBox& box, const Ellipsoid& body,
                                       LatitudeKind latitude, const std::string& file,
                                       std::vector<std::string>& warnings) {
    const OGRSpatialReference srs = parse(wkt, file);
    check_body(srs, body, file);
    if (!(body == Ellipsoid::earth())) return body_crs(srs, body, latitude, file);
    if (is_wgs84(srs)) return plain();
    return earth_crs(srs, box, file, warnings);
}

bool Crs::has_ellipsoidal_heights(const std::string& wkt) {
    if (wkt.empty()) return false;
    const GdalErrors errors;
    OGRSpatialReference srs;
    if (srs.importFromWkt(wkt.c_str()) != OGRERR_NONE) return false;
    return srs.IsCompound() == 0 && srs.GetAxesCount() == 3 && srs.IsGeocentric() == 0;
}

std::optional<Vec3> Crs::normal(double x, double y) const {
    inverse({&x, 1}, {&y, 1});
    if (!std::isfinite(x) || !std::isfinite(y)) return std::nullopt;
    return direction(Geodetic{std::clamp(y, -90.0, 90.0), x});
}

}  // namespace carat
