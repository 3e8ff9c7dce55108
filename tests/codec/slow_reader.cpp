#include "slow_reader.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "../../codec/src/range_built_in.hpp"  // bytes alone: appendix A of the format

namespace slow {
namespace {

// ---- 1 Conventions ----

[[noreturn]] void refuse(const std::string& kind, const std::string& what) { throw Refusal(kind, what); }
void demand(bool kept, const std::string& what) {
    if (!kept) refuse("corrupt", what);
}

std::int64_t reduced(std::int64_t x) {  // modulo 2^32, to [-2^31, 2^31)
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::uint64_t>(x)));
}

std::int64_t floor_div(std::int64_t x, std::int64_t d) { return x >= 0 ? x / d : -((-x + d - 1) / d); }

// Reads numbers one after another out of a stretch of bytes.
struct Cursor {
    const std::uint8_t* at;
    const std::uint8_t* end;
    std::string what;

    std::size_t left() const { return static_cast<std::size_t>(end - at); }
    std::uint64_t number(int bytes) {
        if (left() < static_cast<std::size_t>(bytes)) refuse("truncated", what);
        std::uint64_t value = 0;
        for (int k = bytes; k-- > 0;) value = value << 8 | at[k];
        at += bytes;
        return value;
    }
    int u8() { return static_cast<int>(number(1)); }
    std::uint64_t u16() { return number(2); }
    std::uint64_t u32() { return number(4); }
    std::uint64_t u64() { return number(8); }
    std::int64_t i32() { return reduced(static_cast<std::int64_t>(number(4))); }
    double f64() {
        const std::uint64_t bits = number(8);
        double value = 0;
        std::memcpy(&value, &bits, 8);
        return value;
    }
    double f32() {
        const auto bits = static_cast<std::uint32_t>(number(4));
        float value = 0;
        std::memcpy(&value, &bits, 4);
        return static_cast<double>(value);
    }
    std::vector<std::uint8_t> take(std::uint64_t count) {
        if (left() < count) refuse("truncated", what);
        std::vector<std::uint8_t> out(at, at + count);
        at += count;
        return out;
    }
    std::string text(std::uint64_t count) {
        const auto raw = take(count);
        return {raw.begin(), raw.end()};
    }
    std::uint64_t varint() {
        std::uint64_t value = 0;
        for (int k = 0; k < 5; ++k) {
            const auto byte = static_cast<std::uint64_t>(u8());
            value |= (byte & 127) << (7 * k);
            if (byte >= 128) continue;
            demand(k == 0 || byte != 0, what + ": a varint is not in its fewest bytes");
            demand(value < (std::uint64_t{1} << 32), what + ": a varint is too large");
            return value;
        }
        refuse("corrupt", what + ": a varint is too long");
    }
};

std::uint64_t checksum(const std::uint8_t* bytes, std::uint64_t length) { return XXH3_64bits(bytes, length); }

// Bits of a string, bit 0 of each byte first.
struct Bits {
    const std::vector<std::uint8_t>& bytes;
    std::uint64_t next = 0;

    int bit() {
        if (next >= 8 * bytes.size()) refuse("truncated", "a bit string ends early");
        const int b = bytes[next / 8] >> (next % 8) & 1;
        ++next;
        return b;
    }
    void end() {
        demand(8 * bytes.size() - next < 8, "a bit string has bytes left over");
        while (next < 8 * bytes.size()) demand(bit() == 0, "a bit string is filled with ones");
    }
};

// ---- 2 Lattice and diamonds ----

constexpr std::int64_t kE = std::int64_t{1} << 30;

Point operator+(const Point& p, const Point& q) { return {p.x + q.x, p.y + q.y, p.z + q.z}; }
Point operator-(const Point& p, const Point& q) { return {p.x - q.x, p.y - q.y, p.z - q.z}; }
Point operator*(std::int64_t k, const Point& p) { return {k * p.x, k * p.y, k * p.z}; }
Point over(const Point& p, std::int64_t d) {
    demand(p.x % d == 0 && p.y % d == 0 && p.z % d == 0, "a vertex is no lattice point");
    return {p.x / d, p.y / d, p.z / d};
}
Point cross(const Point& p, const Point& q) {
    return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}
std::int64_t dot(const Point& p, const Point& q) { return p.x * q.x + p.y * q.y + p.z * q.z; }

const std::array<Point, 6> kNormal{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
const std::array<Point, 6> kU{{{0, 1, 0}, {0, 1, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}}};
const std::array<Point, 6> kV{{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 1, 0}, {0, 1, 0}}};

bool on_face(const Point& p, int f) { return dot(p, kNormal[static_cast<std::size_t>(f)]) == kE; }
int face_of(const Point& p) {
    for (int f = 0; f < 6; ++f)
        if (on_face(p, f)) return f;
    refuse("corrupt", "a point off the lattice");
}
std::int64_t shifted_u(const Point& p, int f) { return dot(p, kU[static_cast<std::size_t>(f)]) + kE; }
std::int64_t shifted_v(const Point& p, int f) { return dot(p, kV[static_cast<std::size_t>(f)]) + kE; }
Point on(int f, std::int64_t u, std::int64_t v) {
    const auto k = static_cast<std::size_t>(f);
    return kE * kNormal[k] + (u - kE) * kU[k] + (v - kE) * kV[k];
}

// 2^t, the greatest power of two that divides both.
std::int64_t common_power(std::int64_t u, std::int64_t v) {
    std::int64_t s = 1;
    while (u % (2 * s) == 0 && v % (2 * s) == 0) s *= 2;
    return s;
}

bool turns_outwards(const Point& p, const Point& q, const Point& r) {
    for (int f = 0; f < 6; ++f)
        if (on_face(p, f) && on_face(q, f) && on_face(r, f))
            return dot(cross(q - p, r - q), kNormal[static_cast<std::size_t>(f)]) > 0;
    refuse("corrupt", "a half lies on no face");
}

}  // namespace

Diamond Diamond::at(const Point& centre) {
    Diamond d;
    d.c = centre;
    const int f = face_of(centre);
    const auto fk = static_cast<std::size_t>(f);
    const std::int64_t u = shifted_u(centre, f), v = shifted_v(centre, f);
    demand((u != 0 && u != 2 * kE) || (v != 0 && v != 2 * kE), "a diamond at a cube corner");
    const std::int64_t s = common_power(u, v);
    int k = 30;
    for (std::int64_t power = s; power > 1; power /= 2) --k;
    const bool u_odd = u / s % 2 != 0, v_odd = v / s % 2 != 0;
    const Point eu = s * kU[fk], ev = s * kV[fk];
    Point p, q;
    if (u_odd && v_odd) {
        d.level = 2 * k;
        int su = 1, sv = 1;
        if (d.level > 0) {
            if ((u + s) / (2 * s) % 2 == 0) su = -1;
            if ((v + s) / (2 * s) % 2 == 0) sv = -1;
        }
        d.a = centre - su * eu - sv * ev;
        d.b = centre + su * eu + sv * ev;
        p = centre + su * eu - sv * ev;
        q = centre - su * eu + sv * ev;
    } else {
        d.level = 2 * k + 1;
        const Point along = u_odd ? eu : ev, across = u_odd ? ev : eu;
        d.a = centre - along;
        d.b = centre + along;
        p = centre + across;
        q = centre - across;
        const std::int64_t side = u_odd ? v : u;
        if (side == 0) q = centre - s * kNormal[fk];
        if (side == 2 * kE) p = centre - s * kNormal[fk];
    }
    const bool p_first = turns_outwards(d.a, p, d.b);
    d.x = p_first ? std::array{p, q} : std::array{q, p};
    return d;
}

std::array<Point, 4> Diamond::children() const {
    return {over(a + x[0], 2), over(x[0] + b, 2), over(a + x[1], 2), over(x[1] + b, 2)};
}

Point Diamond::point(int half, int i2, int j2, int n) const {
    const std::int64_t whole = 2 * (n - 1);
    const Point& corner = x[static_cast<std::size_t>(half)];
    const std::int64_t first = half == 0 ? i2 : j2, second = half == 0 ? j2 : i2;
    return over(whole * a + first * (corner - a) + second * (b - corner), whole);
}

std::uint64_t Diamond::id() const {
    const int f = face_of(c);
    const std::int64_t u = shifted_u(c, f) / 32, v = shifted_v(c, f) / 32;
    auto bits = static_cast<std::uint64_t>(f) << 54;
    for (int r = 0; r < 27; ++r) {
        bits |= static_cast<std::uint64_t>(u >> r & 1) << (2 * r);
        bits |= static_cast<std::uint64_t>(v >> r & 1) << (2 * r + 1);
    }
    return bits;
}

// ---- 3 File, 4 Header ----

namespace {

Extent read_extent(Cursor& in) {
    Extent e;
    e.offset = in.u64();
    e.length = in.u32();
    demand(in.u32() == 0, "header: reserved");
    e.checksum = in.u64();
    return e;
}

// Bytes of the file from an offset on; `kind` is the error if they lie outside.
std::vector<std::uint8_t> stretch(const std::vector<std::uint8_t>& file, std::uint64_t offset,
                                  std::uint64_t length, const std::string& what) {
    if (offset > file.size() || length > file.size() - offset)
        refuse("corrupt", what + " lies outside the file");
    const auto begin = file.begin() + static_cast<std::ptrdiff_t>(offset);
    return {begin, begin + static_cast<std::ptrdiff_t>(length)};
}

}  // namespace

void Reader::read_header() {
    Cursor first{bytes_.data(), bytes_.data() + bytes_.size(), "header"};
    const std::vector<std::uint8_t> magic{0x8A, 0x43, 0x41, 0x52, 0x41, 0x54, 0x0D, 0x0A};
    demand(first.take(8) == magic, "wrong magic");
    if (first.u32() != 4) refuse("unsupported", "format version");
    const std::uint64_t length = first.u32();
    demand(length >= 160, "header too short");
    if (length > (std::uint64_t{1} << 24)) refuse("limit", "header too long");
    if (length > bytes_.size()) refuse("truncated", "header");
    Cursor tail{bytes_.data() + length - 8, bytes_.data() + length, "header"};
    demand(tail.u64() == checksum(bytes_.data(), length - 8), "header checksum");

    Cursor in{bytes_.data() + 16, bytes_.data() + length - 8, "header"};
    Header& h = header_;
    h.file_bytes = in.u64();
    if (bytes_.size() < h.file_bytes) refuse("truncated", "file");
    demand(bytes_.size() == h.file_bytes, "file too long");
    h.quantum = in.f64();
    h.tolerance = in.f64();
    h.a = in.f64();
    h.b = in.f64();
    h.p = in.u8();
    h.coder = in.u8();
    if (h.coder > 1) refuse("unsupported", "coder");
    if (in.u8() != 0) refuse("unsupported", "attribute");
    h.deepest = in.u8();
    const std::uint64_t radii = in.u32();
    h.refined = in.u64();
    h.least = in.i32();
    h.greatest = in.i32();
    h.roots = read_extent(in);
    h.directory = read_extent(in);
    const std::uint64_t body = in.u32(), datum = in.u32(), provenance = in.u32();
    const std::uint64_t tables = in.u32();
    h.rms = in.f64();
    demand(in.left() == 4 * radii + body + datum + provenance + tables, "header length");
    demand(h.rms >= 0 && h.rms <= h.tolerance, "RMS tolerance");
    demand(h.coder == 1 || tables == 0, "tables of the gamma coder");
    demand(h.p >= 2 && h.p <= 7, "p");
    demand(h.deepest <= 50 && h.deepest <= 62 - 2 * h.p, "deepest level");
    demand(radii == static_cast<std::uint64_t>(h.deepest) + 1, "number of radii");
    demand(std::isfinite(h.quantum) && h.quantum > 0, "quantum");
    demand(std::isfinite(h.tolerance) && h.tolerance >= h.quantum / 2, "tolerance");
    demand(h.a >= 1e-3 && h.a <= 1e12 && h.b <= h.a && h.b >= h.a / 10, "semi-axes");
    demand(h.least <= h.greatest, "least and greatest height");
    for (std::uint64_t k = 0; k < radii; ++k) {
        const std::int64_t r = in.i32();
        demand(r >= 0 && r <= (std::int64_t{1} << 29), "radius");
        demand(static_cast<double>(r) * h.quantum + h.quantum / 2 <= h.tolerance, "radius above tolerance");
        h.radii.push_back(r);
    }
    h.body = in.text(body);
    h.datum = in.text(datum);
    h.provenance = in.text(provenance);
    h.tables = in.take(tables);
}

// ---- 8.2 Gamma code (the root values need it too) ----

namespace {

int gamma_length(Bits& in) {
    int t = 0;
    while (in.bit() == 0) {
        ++t;
        demand(t <= 32, "gamma code above 2^32");
    }
    return t;
}

std::int64_t gamma_suffix(Bits& in, int t) {
    std::uint64_t x = std::uint64_t{1} << t;
    for (int k = 0; k < t; ++k) x |= static_cast<std::uint64_t>(in.bit()) << k;
    demand(x <= (std::uint64_t{1} << 32), "gamma code above 2^32");
    const auto wide = static_cast<std::int64_t>(x);
    return x % 2 == 1 ? (wide - 1) / 2 : -(wide / 2);
}

std::int64_t gamma_value(Bits& in) {
    const int t = gamma_length(in);
    return gamma_suffix(in, t);
}

}  // namespace

// ---- 5 Root values ----

void Reader::read_roots() {
    const auto raw = stretch(bytes_, header_.roots.offset, header_.roots.length, "root values");
    demand(checksum(raw.data(), raw.size()) == header_.roots.checksum, "root values checksum");
    Bits in{raw};
    const int size = n();
    const std::int64_t step = 2 * header_.radii[0] + 1;
    std::map<Point, std::int64_t> shared;
    for (int f = 0; f < 6; ++f) {
        const Diamond d = Diamond::at(on(f, kE, kE));
        Matrix& k = roots_[static_cast<std::size_t>(f)];
        k.assign(static_cast<std::size_t>(size * size), 0);
        const auto at = [&](int i, int j) -> std::int64_t& {
            return k[static_cast<std::size_t>(i * size + j)];
        };
        for (int i = 0; i < size; ++i)
            for (int j = 0; j < size; ++j) {
                const Point here = d.point(i >= j ? 0 : 1, 2 * i, 2 * j, size);
                if (const auto it = shared.find(here); it != shared.end()) {
                    at(i, j) = it->second;
                    continue;
                }
                std::int64_t prediction = 0;
                if (i == 0 && j > 0) prediction = at(0, j - 1);
                if (j == 0 && i > 0) prediction = at(i - 1, 0);
                if (i > 0 && j > 0) {
                    const std::int64_t w = at(i, j - 1), north = at(i - 1, j), m = at(i - 1, j - 1);
                    if (m >= std::max(w, north))
                        prediction = std::min(w, north);
                    else if (m <= std::min(w, north))
                        prediction = std::max(w, north);
                    else
                        prediction = reduced(w + north - m);
                }
                at(i, j) = reduced(prediction + gamma_value(in));
                shared[here] = at(i, j);
            }
    }
    in.end();
    for (Matrix& k : roots_)
        for (std::int64_t& value : k) value = reduced(value * step);
}

// ---- 6 Directory ----

void Reader::read_directory() {
    const auto top = stretch(bytes_, header_.directory.offset, header_.directory.length, "directory");
    demand(checksum(top.data(), top.size()) == header_.directory.checksum, "directory checksum");
    demand(top.size() % 32 == 0, "directory length");
    Cursor in{top.data(), top.data() + top.size(), "directory"};
    std::pair<std::uint64_t, int> last{0, -1};
    std::optional<std::uint64_t> page;
    while (in.left() > 0) {
        const std::uint64_t first_key = in.u64();
        const auto first_slot = static_cast<int>(in.u16());
        demand(in.u16() == 0, "directory: reserved");
        const std::uint64_t entries = in.u32(), offset = in.u64(), sum = in.u64();
        demand(entries >= 1 && entries <= 1024, "directory: size of a block");
        const auto raw = stretch(bytes_, offset, 24 * entries, "directory block");
        demand(checksum(raw.data(), raw.size()) == sum, "directory block checksum");
        Cursor block{raw.data(), raw.data() + raw.size(), "directory block"};
        for (std::uint64_t k = 0; k < entries; ++k) {
            PartPlace place;
            place.key = block.u64();
            place.offset = block.u64();
            place.length = block.u32();
            place.first_slot = static_cast<int>(block.u16());
            demand(block.u16() == 0, "directory block: reserved");
            if (k == 0)
                demand(place.key == first_key && place.first_slot == first_slot, "directory: first entry");
            demand(place.offset <= bytes_.size() && place.length <= bytes_.size() - place.offset,
                   "part outside");
            demand(place.length <= (1u << 20), "part too long");
            demand(std::pair(place.key, place.first_slot) > last, "directory: order");
            demand(place.first_slot <= 76, "directory: first slot");
            demand(page == place.key || place.first_slot == 0, "page without its first slots");
            last = {place.key, place.first_slot};
            page = place.key;
            places_[last] = place;
        }
    }
}

// ---- 7 Pages ----

namespace {

// 7.1: the square, by centre, whose page holds a diamond.
Point page_square(const Diamond& d) {
    const int level = d.level / 6 * 6;
    const std::int64_t h = kE >> (level / 2);
    std::optional<std::pair<std::uint64_t, Point>> best;
    for (int f = 0; f < 6; ++f) {
        if (!on_face(d.c, f)) continue;
        const std::int64_t u = shifted_u(d.c, f), v = shifted_v(d.c, f);
        // Squares of this level have centres at odd multiples of h; those within h of the point contain it.
        for (std::int64_t cu = u / (2 * h) * 2 * h - h; cu <= u + h; cu += 2 * h)
            for (std::int64_t cv = v / (2 * h) * 2 * h - h; cv <= v + h; cv += 2 * h) {
                if (cu < 0 || cv < 0 || cu > 2 * kE || cv > 2 * kE) continue;
                if (std::abs(cu - u) > h || std::abs(cv - v) > h) continue;
                const Point square = on(f, cu, cv);
                const std::uint64_t id = Diamond::at(square).id();
                if (!best || id < best->first) best = {id, square};
            }
    }
    return best->second;
}

std::uint64_t page_key(const Point& square) {
    const Diamond d = Diamond::at(square);
    return (static_cast<std::uint64_t>(d.level / 6) << 57) + d.id();
}

// The square of a key, by centre; refuses keys of no square.
Point key_square(std::uint64_t key) {
    const std::uint64_t id = key & ((std::uint64_t{1} << 57) - 1);
    const int f = static_cast<int>(id >> 54);
    std::int64_t u = 0, v = 0;
    for (int r = 0; r < 27; ++r) {
        u |= static_cast<std::int64_t>(id >> (2 * r) & 1) << (r + 5);
        v |= static_cast<std::int64_t>(id >> (2 * r + 1) & 1) << (r + 5);
    }
    demand(f < 6 && u > 0 && v > 0 && u < 2 * kE && v < 2 * kE, "impossible page key");
    const Point square = on(f, u, v);
    const Diamond d = Diamond::at(square);
    demand(d.level <= 50 && d.level % 6 == 0 && page_key(square) == key, "impossible page key");
    return square;
}

// 7.2
int slot_of(const Diamond& d, const Point& square) {
    const int j = d.level % 6, f = face_of(square);
    const std::int64_t w = std::int64_t{1} << (j / 2), half = kE >> (Diamond::at(square).level / 2),
                       h = half / w;
    const std::int64_t u = shifted_u(d.c, f) - (shifted_u(square, f) - half);
    const std::int64_t v = shifted_v(d.c, f) - (shifted_v(square, f) - half);
    const auto x = static_cast<int>(u / (2 * h)), y = static_cast<int>(v / (2 * h));
    const bool u_odd = u / h % 2 != 0;
    switch (j) {
        case 0:
            return 0;
        case 1:
            return u_odd ? 1 + y : 3 + x;
        case 2:
            return 5 + 2 * y + x;
        case 3:
            return u_odd ? 9 + 2 * y + x : 15 + 3 * y + x;
        case 4:
            return 21 + 4 * y + x;
        default:
            return u_odd ? 37 + 4 * y + x : 57 + 5 * y + x;
    }
}

double summary_delta(int index) {
    static constexpr std::array<int, 16> kSixteenths{65536,  68438,  71468,  74632, 77936,  81387,
                                                     84990,  88753,  92682,  96786, 101071, 105546,
                                                     110218, 115098, 120194, 125515};
    return kSixteenths[static_cast<std::size_t>(index % 16)] / 65536.0 * std::pow(2.0, index / 16 - 40);
}

int sub_level(int slot) {
    return slot < 1 ? 0 : slot < 5 ? 1 : slot < 9 ? 2 : slot < 21 ? 3 : slot < 37 ? 4 : 5;
}

}  // namespace

// 10: multiples of 2^k quanta
std::int64_t Reader::summary_unit(int level) const {
    const int e = std::clamp(std::ilogb(header_.a / header_.quantum), -100, 100);
    const int k = std::max(0, std::min({24, e - 19, e - header_.p - 3 - level / 2}));
    return std::int64_t{1} << k;
}

// 7.3, 7.4
Reader::Part Reader::parse_part(const PartPlace& place) {
    const auto raw = stretch(bytes_, place.offset, place.length, "part");
    Cursor in{raw.data(), raw.data() + raw.size(), "part of page " + std::to_string(place.key)};
    const int level = Diamond::at(key_square(place.key)).level;
    demand(in.u64() == checksum(raw.data() + 8, raw.size() - 8), in.what + ": checksum");
    demand(in.u64() == place.key, in.what + ": key");
    const int kind = in.u8();
    demand(kind <= 1, in.what + ": kind");
    Part part;
    part.first = place.first_slot;
    part.zero = kind == 1;
    if (part.zero) {
        demand(place.first_slot == 0, in.what + ": zero page in parts");
        part.zero_end = in.u8();
        demand(in.u16() == 0, in.what + ": reserved");
        demand(part.zero_end > level && part.zero_end <= header_.deepest, in.what + ": Z");
    } else {
        demand(in.u8() == place.first_slot, in.what + ": first slot");
        part.slots = in.u8();
        demand(part.slots >= 1 && part.first + part.slots <= 77, in.what + ": slots");
        demand(in.u8() == 0, in.what + ": reserved");
    }
    part.least = in.i32();
    if (part.zero) {
        part.greatest = in.i32();
        demand(part.least <= part.greatest, in.what + ": range");
        for (int l = level; l < part.zero_end; ++l) part.zero_delta.push_back(static_cast<int>(in.u16()));
        for (const int index : part.zero_delta) demand(index <= 2047, in.what + ": delta");
        demand(in.left() == 0, in.what + ": bytes left over");
        return part;
    }
    part.delta = static_cast<int>(in.u16());
    demand(part.delta <= 2047, in.what + ": delta");
    demand(in.u16() == 0, in.what + ": reserved");
    const auto bitmap = in.take(static_cast<std::uint64_t>((part.slots + 7) / 8));
    for (int k = 0; k < 8 * static_cast<int>(bitmap.size()); ++k) {
        if ((bitmap[static_cast<std::size_t>(k / 8)] >> (k % 8) & 1) == 0) continue;
        demand(k < part.slots, in.what + ": bitmap");
        demand(level + sub_level(part.first + k) < header_.deepest, in.what + ": too deep");
        part.entries[part.first + k] = {};
    }
    std::vector<std::uint64_t> lengths;
    for (auto& [slot, entry] : part.entries) {
        const int info = in.u8();
        entry.mode = info & 3;
        entry.leaf = (info & 4) != 0 ? 4 : 2;
        entry.order = 2 * (info >> 3 & 3) + 2;
        entry.gamma = (info & 32) != 0;
        demand(entry.mode <= 2 && entry.order <= 6 && info < 64, in.what + ": mode");
        for (Summary& s : entry.summary) {  // 10
            const std::int64_t unit = summary_unit(level + sub_level(slot));
            const std::int64_t base = floor_div(part.least, unit) * unit;
            const std::int64_t least = base + unit * static_cast<std::int64_t>(in.varint());
            const std::int64_t most = least + unit * static_cast<std::int64_t>(in.varint());
            const std::int64_t below = static_cast<std::int64_t>(in.varint());
            demand(least < 2147483648 && most < 2147483648 + unit && below <= part.delta,
                   in.what + ": summary");
            s = {least, std::min<std::int64_t>(most, 2147483647),
                 summary_delta(part.delta - static_cast<int>(below))};
        }
        lengths.push_back(in.varint());
    }
    std::size_t k = 0;
    for (auto& [slot, entry] : part.entries) entry.blob = in.take(lengths[k++]);
    demand(in.left() == 0, in.what + ": bytes left over");
    return part;
}

// The part of a page that covers a slot; null if there is no such page.
const Reader::Part* Reader::part(std::uint64_t key, int slot) {
    auto it = places_.upper_bound({key, slot});
    if (it == places_.begin()) return nullptr;
    --it;
    if (it->first.first != key) return nullptr;
    if (!parts_.contains(it->first)) parts_[it->first] = parse_part(it->second);
    const Part& found = parts_.at(it->first);
    demand(slot < found.first + found.slots, "no part covers a slot");
    return &found;
}

Reader::Count Reader::count() {
    Count out;
    for (const auto& [where, place] : places_) {
        const Part* found = part(where.first, where.second);
        ++out.parts;
        out.pages += where.second == 0 ? 1 : 0;
        out.zero_pages += found->zero ? 1 : 0;
    }
    return out;
}

// 7.5
std::optional<Reader::Found> Reader::find(const Point& centre) {
    const Diamond d = Diamond::at(centre);
    if (d.level >= header_.deepest) return std::nullopt;
    Point square = page_square(d);
    int slot = slot_of(d, square);
    for (bool own = true;; own = false) {
        if (const Part* found = part(page_key(square), slot)) {
            if (found->zero)
                return d.level < found->zero_end ? std::optional<Found>{{found, nullptr}} : std::nullopt;
            const auto it = found->entries.find(slot);
            if (!own || it == found->entries.end()) return std::nullopt;
            return Found{found, &it->second};
        }
        // The parent page: the square one band coarser that contains this square, so its centre.
        const Diamond page = Diamond::at(square);
        if (page.level == 0) return std::nullopt;
        const std::int64_t h = kE >> ((page.level - 6) / 2);
        const int f = face_of(square);
        square =
            on(f, shifted_u(square, f) / (2 * h) * 2 * h + h, shifted_v(square, f) / (2 * h) * 2 * h + h);
        slot = 0;
    }
}

bool Reader::refined(const Point& centre) { return find(centre).has_value(); }

// ---- 8 Residuals of a diamond ----

namespace {

struct Square {
    int i, j, side;
};

// 8.3: the flags, the lengths of all values, their suffixes.
Matrix read_matrix(Bits& in, int rows, int side, int leaf) {
    Matrix values(static_cast<std::size_t>(rows * rows));
    std::vector<Square> squares;
    if (in.bit() == 1) squares.push_back({0, 0, side});
    while (!squares.empty() && squares.front().side > leaf) {
        std::vector<Square> next;
        for (const Square& s : squares) {
            const int half = s.side / 2;
            bool any = false;
            for (int q = 0; q < 4; ++q) {
                const bool flag = q == 3 && !any ? true : in.bit() == 1;
                if (flag) next.push_back({s.i + q / 2 * half, s.j + q % 2 * half, half});
                any = any || flag;
            }
        }
        squares = next;
    }
    std::vector<std::size_t> places;
    for (const Square& s : squares)
        for (int r = s.i; r < s.i + leaf; ++r)
            for (int c = s.j; c < s.j + leaf; ++c)
                if (r < rows && c < rows) places.push_back(static_cast<std::size_t>(r * rows + c));
    std::vector<int> lengths;
    for (std::size_t k = 0; k < places.size(); ++k) lengths.push_back(gamma_length(in));
    for (std::size_t k = 0; k < places.size(); ++k) values[places[k]] = gamma_suffix(in, lengths[k]);
    return values;
}

// ---- 8.4 to 8.6 Range code ----

constexpr std::int64_t kTwo32 = std::int64_t{1} << 32;

int floor_log2(std::int64_t x) {
    int e = 0;
    while (x >= 2) {
        x /= 2;
        ++e;
    }
    return e;
}

// 8.5: which token slots belong to, in a context. Found by walking the buckets, not by arithmetic on entries.
struct Alias {
    std::array<int, 64> cutoff{}, other{}, first{};  // of the alias: number of the slot at the cutoff

    explicit Alias(const std::array<std::int64_t, 64>& f) {
        std::vector<int> low, high;
        for (int t = 0; t < 64; ++t) {
            cutoff[static_cast<std::size_t>(t)] = static_cast<int>(f[static_cast<std::size_t>(t)]);
            if (cutoff[static_cast<std::size_t>(t)] < 64) low.push_back(t);
            if (cutoff[static_cast<std::size_t>(t)] > 64) high.push_back(t);
        }
        while (!high.empty()) {
            const int giver = high.back(), taker = low.back();
            high.pop_back();
            low.pop_back();
            int& has = cutoff[static_cast<std::size_t>(giver)];
            has -= 64 - cutoff[static_cast<std::size_t>(taker)];
            other[static_cast<std::size_t>(taker)] = giver;
            first[static_cast<std::size_t>(taker)] = has;
            if (has < 64) low.push_back(giver);
            if (has > 64) high.push_back(giver);
        }
    }
};

struct RangeReader {
    const std::vector<std::array<std::int64_t, 64>>& frequencies;  // by context
    const Matrix& known;
    int m, rows;
    std::int64_t step;

    std::int64_t at(int i, int j) const { return known[static_cast<std::size_t>(i * m + j)]; }
    static int held(int x, int least, int most) { return x < least ? least : x > most ? most : x; }

    // 8.6
    std::int64_t scaled(std::int64_t difference) const {
        int shift = floor_log2(step) + 1 - 12;
        if (shift < 0) shift = 0;
        std::int64_t x = reduced(difference);
        x = (x < 0 ? -x : x) >> shift;
        return x > (1 << 23) ? 1 << 23 : x;
    }
    std::int64_t scaled_step() const {
        const int shift = floor_log2(step) + 1 - 12;
        return shift > 0 ? step >> shift : step;
    }
    std::int64_t roughness(int i, int j) const {  // of vertex (i, j), held inside the matrix
        i = held(i, 0, m - 1);
        j = held(j, 0, m - 1);
        const int x = held(i, 1, m - 2), y = held(j, 1, m - 2);
        return scaled(at(i, y - 1) - 2 * at(i, y) + at(i, y + 1)) +
               scaled(at(x - 1, j) - 2 * at(x, j) + at(x + 1, j));
    }
    std::int64_t corner_activity(int i, int j) const {
        const std::array<std::int64_t, 4> corners{at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)};
        const std::int64_t total = corners[0] + corners[1] + corners[2] + corners[3];
        std::int64_t sum = 24 * scaled_step();
        for (const std::int64_t corner : corners) sum += 7 * scaled(4 * corner - total);
        return sum +
               5 * (roughness(i, j) + roughness(i, j + 1) + roughness(i + 1, j) + roughness(i + 1, j + 1));
    }
    std::int64_t activity(bool corners, int i, int j) const {
        if (corners) return corner_activity(i, j);
        const std::array<std::int64_t, 4> weight{1, 2, 2, 1};
        std::int64_t sum = 24 * scaled_step();
        for (int a = 0; a < 4; ++a)
            for (int b = 0; b < 4; ++b)
                sum += weight[static_cast<std::size_t>(a)] * weight[static_cast<std::size_t>(b)] *
                       roughness(i + a - 1, j + b - 1);
        return sum + 8 * scaled(at(i, j) + at(i + 1, j + 1) - at(i, j + 1) - at(i + 1, j));
    }
    static int log8(std::int64_t u) {
        const int e = floor_log2(u);
        return 8 * e + static_cast<int>(u >> (e - 3)) - 8;
    }

    Matrix read(const std::vector<std::uint8_t>& bytes) const {
        demand(!bytes.empty(), "an empty range code");
        const int head = bytes[0], states = 1 << (head % 8), offset = head / 8 % 16 - 8;
        demand(head % 8 <= 5, "form of a range code");
        // The states, then 16-bit words.
        const std::vector<std::uint8_t> code(bytes.begin() + 1, bytes.end());
        Bits first{code};
        std::vector<std::int64_t> x;
        for (int lane = 0; lane < states; ++lane) {
            int length = 16;
            for (int k = 0; k < 4; ++k) length += first.bit() << k;
            std::int64_t state = std::int64_t{1} << length;
            for (int k = 0; k < length; ++k) state += std::int64_t{first.bit()} << k;
            x.push_back(state);
        }
        while (first.next % 8 != 0) demand(first.bit() == 0, "states of a range code are filled with ones");
        std::size_t next = 1 + first.next / 8;
        const auto byte = [&] {
            if (next >= bytes.size()) refuse("truncated", "a range code ends early");
            return static_cast<std::int64_t>(bytes[next++]);
        };
        std::vector<int> tokens(static_cast<std::size_t>(rows * rows), 0);
        std::map<int, Alias> aliases;
        for (int pass = 0; pass < 2; ++pass) {
            int number = 0;
            const std::vector<int> before = tokens;  // a pass sees the one before only
            for (int i = 0; i < rows; ++i)
                for (int j = 0; j < rows; ++j) {
                    if ((i + j) % 2 != pass) continue;
                    std::int64_t u = activity(head >= 128, i, j);
                    const auto neighbour = [&](int r, int c) {
                        if (r < 0 || c < 0 || r >= rows || c >= rows) return;
                        u += 48 * scaled_step() * magnitude(before[static_cast<std::size_t>(r * rows + c)]);
                    };
                    if (pass == 1) {
                        neighbour(i - 1, j);
                        neighbour(i + 1, j);
                        neighbour(i, j - 1);
                        neighbour(i, j + 1);
                    }
                    const std::int64_t twice = log8(u) - log8(24 * scaled_step()) + 2 * (8 + offset);
                    const int context = held(static_cast<int>(floor_div(twice, 2)), 0, 63) + 64 * pass;
                    const auto& f = frequencies[static_cast<std::size_t>(context)];
                    const Alias& alias = aliases.try_emplace(context, f).first->second;
                    std::int64_t& state = x[static_cast<std::size_t>(number++ % states)];
                    const auto slot = static_cast<int>(state % 4096), bucket = slot / 64, inside = slot % 64;
                    const auto b = static_cast<std::size_t>(bucket);
                    const bool own = inside < alias.cutoff[b];
                    const int token = own ? bucket : alias.other[b];
                    const std::int64_t place = own ? inside : alias.first[b] + inside - alias.cutoff[b];
                    state = f[static_cast<std::size_t>(token)] * (state / 4096) + place;
                    if (state < 65536) {
                        const std::int64_t low = byte();
                        state = state * 65536 + low + 256 * byte();
                    }
                    tokens[static_cast<std::size_t>(i * rows + j)] = token;
                }
        }
        std::vector<std::uint8_t> raw;
        for (const std::int64_t state : x) {
            demand(state < 131072, "the last state of a range code");
            raw.push_back(static_cast<std::uint8_t>(state % 256));
            raw.push_back(static_cast<std::uint8_t>(state / 256 % 256));
        }
        raw.insert(raw.end(), bytes.begin() + static_cast<std::ptrdiff_t>(next), bytes.end());
        return indices(tokens, raw, 16 * states);
    }

    static std::int64_t least(int token) {
        if (token < 16) return token;
        const int octave = token / 4;  // 16 to 19 are the quarters of 2^4 to 2^5
        return (std::int64_t{4} + token % 4) << (octave - 2);
    }
    static int raw_bits(int token) { return token < 16 ? 0 : token == 63 ? 32 : token / 4 - 2; }
    static std::int64_t magnitude(int token) {
        if (token == 63) return 63;
        const std::int64_t x = least(token);
        return x < 63 ? x : 63;
    }
    static Matrix indices(const std::vector<int>& tokens, const std::vector<std::uint8_t>& raw, int kept) {
        std::int64_t total = 0;
        for (const int t : tokens) total += raw_bits(t) + (t != 0 ? 1 : 0);
        const std::int64_t stored = total > kept ? (total - kept + 7) / 8 : 0;
        demand(static_cast<std::int64_t>(raw.size()) == kept / 8 + stored, "raw bits of a range code");
        Bits in{raw};
        std::vector<int> negative;
        for (const int t : tokens) negative.push_back(t != 0 ? in.bit() : 0);
        Matrix out;
        for (std::size_t k = 0; k < tokens.size(); ++k) {
            const int t = tokens[k];
            std::int64_t e = t == 63 ? 0 : least(t);
            for (int b = 0; b < raw_bits(t); ++b) e += static_cast<std::int64_t>(in.bit()) << b;
            out.push_back(reduced(negative[k] != 0 ? -e : e));
        }
        while (in.next < 8 * raw.size()) demand(in.bit() == 0, "a range code is filled with ones");
        return out;
    }
};

std::uint64_t take_varint(const std::vector<std::uint8_t>& bytes, std::size_t& next) {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
        if (next >= bytes.size()) refuse("truncated", "a length in a blob");
        const std::uint64_t b = bytes[next++];
        value |= (b & 0x7F) << shift;
        if (b >= 0x80) continue;
        demand(value < static_cast<std::uint64_t>(kTwo32) && (b != 0 || shift == 0), "a length in a blob");
        return value;
    }
    refuse("corrupt", "a length in a blob");
}

// 8.5: the frequencies of all contexts.
std::vector<std::array<std::int64_t, 64>> read_tables(const std::vector<std::uint8_t>& bytes) {
    Bits in{bytes};
    std::vector<std::array<std::int64_t, 64>> out;
    std::array<std::int64_t, 64> f{};
    for (int context = 0; context < 128; ++context) {
        if (in.bit() == 1) {
            int count = 0;
            for (int k = 0; k < 6; ++k) count |= in.bit() << k;
            std::int64_t left = 4096;
            for (int t = 0; t < 63; ++t) {
                std::int64_t& x = f[static_cast<std::size_t>(t)];
                x = t < count ? x + gamma_value(in) : 0;
                demand(x >= 0 && x < left, "a frequency");
                left -= x;
            }
            f[63] = left;
        }
        demand(f[63] > 0 && f[63] < 4096, "frequencies");
        out.push_back(f);
    }
    in.end();
    return out;
}

// ---- 9 Reconstruction ----

// 9.1
Matrix pred(const Matrix& k, int m, int order) {
    const auto at = [&](int i, int j) { return k[static_cast<std::size_t>(i * m + j)]; };
    Matrix out;
    for (int i = 0; i < m - 1; ++i)
        for (int j = 0; j < m - 1; ++j) {
            const std::int64_t four = at(i, j) + at(i, j + 1) + at(i + 1, j) + at(i + 1, j + 1);
            const bool row_border = i == 0 || i == m - 2, column_border = j == 0 || j == m - 2;
            const auto beside = [&] {
                return at(i, j - 1) + at(i, j + 2) + at(i + 1, j - 1) + at(i + 1, j + 2);
            };
            const auto above = [&] {
                return at(i - 1, j) + at(i + 2, j) + at(i - 1, j + 1) + at(i + 2, j + 1);
            };
            const bool order6 = order == 6 && i >= 2 && i <= m - 4 && j >= 2 && j <= m - 4;
            std::int64_t value = 0;
            if (order6) {
                const std::int64_t diagonal =
                    at(i - 1, j - 1) + at(i - 1, j + 2) + at(i + 2, j - 1) + at(i + 2, j + 2);
                const std::int64_t beyond = at(i - 2, j) + at(i - 2, j + 1) + at(i + 3, j) +
                                            at(i + 3, j + 1) + at(i, j - 2) + at(i + 1, j - 2) +
                                            at(i, j + 3) + at(i + 1, j + 3);
                value =
                    floor_div(174 * four - 27 * (beside() + above()) + 2 * diagonal + 3 * beyond + 256, 512);
            } else if (order == 2 || (row_border && column_border))
                value = floor_div(four + 2, 4);
            else if (row_border)
                value = floor_div(9 * four - beside() + 16, 32);
            else if (column_border)
                value = floor_div(9 * four - above() + 16, 32);
            else
                value = floor_div(10 * four - beside() - above() + 16, 32);
            out.push_back(reduced(value));
        }
    return out;
}

}  // namespace

Reader::Reader(std::vector<std::uint8_t> bytes, std::vector<std::uint8_t> built_in)
    : bytes_(std::move(bytes)), built_in_(std::move(built_in)) {
    read_header();
    if (header_.coder == 1) frequencies_ = read_tables(header_.tables.empty() ? built_in_ : header_.tables);
    read_roots();
    read_directory();
}

// Appendix A.
std::vector<std::uint8_t> Reader::built_in_tables() {
    return {std::begin(carat::kBuiltInRangeTables), std::end(carat::kBuiltInRangeTables)};
}

// 9.2
const Refined& Reader::refine(const Point& centre) {
    if (const auto it = refined_.find(centre); it != refined_.end()) return it->second;
    const std::optional<Found> found = find(centre);
    demand(found.has_value(), "asked to refine a leaf");
    const Heights& h = heights(centre);
    demand(h.has[0] && h.has[1], "refined without both parents");
    const int size = n(), cells = size - 1, inner = size - 2;
    Entry entry;
    if (found->entry != nullptr) entry = *found->entry;
    Matrix qc(static_cast<std::size_t>(cells * cells)), qv(static_cast<std::size_t>(inner * inner));
    const std::int64_t step = 2 * header_.radii[static_cast<std::size_t>(Diamond::at(centre).level) + 1] + 1;
    const bool range = header_.coder == 1 && !entry.gamma && !entry.blob.empty();
    if (!entry.blob.empty() && !range) {
        Bits in{entry.blob};
        qc = read_matrix(in, cells, cells, entry.leaf);
        if (entry.mode != 0) qv = read_matrix(in, inner, cells, entry.leaf);
        in.end();
    }
    // 8.4: in modes 1 and 2 two range codes, the first after its length
    std::array<std::vector<std::uint8_t>, 2> codes;
    if (range && entry.mode == 0) codes[0] = entry.blob;
    if (range && entry.mode != 0) {
        std::size_t next = 0;
        const std::uint64_t first = take_varint(entry.blob, next);
        if (first > entry.blob.size() - next) refuse("truncated", "a blob ends inside its first matrix");
        const auto middle = entry.blob.begin() + static_cast<std::ptrdiff_t>(next + first);
        codes[0].assign(entry.blob.begin() + static_cast<std::ptrdiff_t>(next), middle);
        codes[1].assign(middle, entry.blob.end());
    }
    const auto read_range = [&](std::size_t which, const Matrix& known, int m, int rows, Matrix& out) {
        if (range && !codes[which].empty())
            out = RangeReader{frequencies_, known, m, rows, step}.read(codes[which]);
    };
    if (entry.mode == 1) read_range(0, h.p, size, inner, qv);
    Refined out;
    out.v = h.p;
    const auto inside = [&](auto value) {  // V(i, j) = value(index in P, index in the inner matrix)
        for (int i = 1; i <= inner; ++i)
            for (int j = 1; j <= inner; ++j) {
                const auto at = static_cast<std::size_t>(i * size + j);
                out.v[at] = reduced(value(at, static_cast<std::size_t>((i - 1) * inner + j - 1)));
            }
    };
    if (entry.mode == 1) inside([&](std::size_t at, std::size_t k) { return h.p[at] + step * qv[k]; });
    read_range(entry.mode == 1 ? 1 : 0, out.v, size, cells, qc);
    out.c = pred(out.v, size, entry.order);
    for (std::size_t k = 0; k < out.c.size(); ++k) out.c[k] = reduced(out.c[k] + step * qc[k]);
    if (entry.mode == 2) {
        read_range(1, out.c, cells, inner, qv);
        const Matrix predicted = pred(out.c, cells, entry.order);
        inside([&](std::size_t at, std::size_t k) { return 2 * h.p[at] - predicted[k] + step * qv[k]; });
    }
    return refined_[centre] = out;
}

// 9.3
const std::map<Point, std::int64_t>& Reader::samples(const Point& centre) {
    if (const auto it = samples_.find(centre); it != samples_.end()) return it->second;
    const Refined& r = refine(centre);
    const Diamond d = Diamond::at(centre);
    std::map<Point, std::int64_t>& out = samples_[centre];
    const int size = n();
    for (int i = 0; i < size; ++i)
        for (int j = 0; j < size; ++j) {
            const int half = i >= j ? 0 : 1;
            out[d.point(half, 2 * i, 2 * j, size)] = r.v[static_cast<std::size_t>(i * size + j)];
            if (i < size - 1 && j < size - 1)
                out[d.point(half, 2 * i + 1, 2 * j + 1, size)] =
                    r.c[static_cast<std::size_t>(i * (size - 1) + j)];
        }
    return out;
}

const Heights& Reader::heights(const Point& centre) {
    if (const auto it = heights_.find(centre); it != heights_.end()) return it->second;
    const Diamond d = Diamond::at(centre);
    if (d.level == 0)
        return heights_[centre] = {{true, true}, roots_[static_cast<std::size_t>(face_of(centre))]};
    Heights out;
    const int size = n();
    out.p.assign(static_cast<std::size_t>(size * size), 0);
    for (int half = 0; half < 2; ++half) {
        const Point& parent = d.x[static_cast<std::size_t>(half)];
        if (!refined(parent)) continue;
        out.has[static_cast<std::size_t>(half)] = true;
        const std::map<Point, std::int64_t>& known = samples(parent);
        for (int i = 0; i < size; ++i)
            for (int j = 0; j < size; ++j)
                if (half == 0 ? i >= j : i <= j)
                    out.p[static_cast<std::size_t>(i * size + j)] =
                        known.at(d.point(half, 2 * i, 2 * j, size));
    }
    return heights_[centre] = out;
}

// ---- 10 Summaries ----

Summary Reader::summary(const Point& centre, int half) {
    const std::optional<Found> found = find(centre);
    demand(found.has_value(), "a leaf has no summary");
    const Part& part = *found->part;
    if (found->entry == nullptr) {
        const int top = part.zero_end - static_cast<int>(part.zero_delta.size());
        const auto level = static_cast<std::size_t>(Diamond::at(centre).level - top);
        return {part.least, part.greatest, summary_delta(part.zero_delta[level])};
    }
    return found->entry->summary[static_cast<std::size_t>(half)];
}

}  // namespace slow
