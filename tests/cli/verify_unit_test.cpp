// carat verify, and the library behind it: sound files pass, each kind of damage is found and named.
#include "carat/codec/verify.hpp"
#include "carat/globe/error.hpp"
#include "mini_builder.hpp"
#include "program.hpp"
#include "rasters.hpp"

namespace carat::test {
namespace {

using VerifyProgram = Program;

void flip(const fs::path& file, std::uintmax_t at) {
    std::fstream io(file, std::ios::binary | std::ios::in | std::ios::out);
    io.seekg(static_cast<std::streamoff>(at));
    const int byte = io.get();
    io.seekp(static_cast<std::streamoff>(at));
    io.put(static_cast<char>(byte ^ 0x10));
}

TEST_F(VerifyProgram, ASoundFileIsOk) {
    write_raster(path("hills.tif"), hills());
    ASSERT_EQ(carat("build -q --layer hills.tif --tolerance 2 -o a.carat").exit, 0);
    const Outcome text = carat("verify a.carat");
    EXPECT_EQ(text.exit, 0);
    EXPECT_TRUE(contains(text.out, "a.carat: ok: ")) << text.out;
    EXPECT_FALSE(contains(text.out, "ok: 0 bytes")) << text.out;
    const auto json = carat("verify --json a.carat").json();
    EXPECT_EQ(json.at("ok"), true);
    EXPECT_EQ(json.at("damage_count"), 0);
    EXPECT_GT(json.at("diamonds"), 0);
    EXPECT_EQ(json.at("file_bytes"), fs::file_size(path("a.carat")));
    EXPECT_EQ(json.at("decoded"), json.at("diamonds"));
    EXPECT_GT(json.at("shared_heights_checked"), 0);
}

TEST_F(VerifyProgram, ItSaysWhatTheFilePromises) {
    write_raster(path("hills.tif"), hills());
    ASSERT_EQ(carat("build -q --layer hills.tif --tolerance 2 -o a.carat").exit, 0);
    ASSERT_EQ(carat("build -q --layer hills.tif --rms 1 -o b.carat").exit, 0);
    EXPECT_TRUE(contains(carat("verify a.carat").out, "guaranteed at the file's own samples: 2 m"));
    EXPECT_FALSE(contains(carat("verify a.carat").out, "root mean square"));
    EXPECT_TRUE(contains(carat("verify b.carat").out, "guaranteed root mean square there: 1 m"));
    const auto a = carat("verify --json a.carat").json(), b = carat("verify --json b.carat").json();
    EXPECT_EQ(a.at("guaranteed_at_lattice_m"), 2);
    EXPECT_TRUE(a.at("guaranteed_rms_at_lattice_m").is_null());
    EXPECT_EQ(b.at("guaranteed_rms_at_lattice_m"), 1);
}

// All of a flat world is zero: a few bytes a page, whatever the depth.
TEST_F(VerifyProgram, ZeroPagesAreLookedAtToALimit) {
    MiniPlan plan;
    plan.source = constant(512);
    plan.depth = 9;
    const MiniBuild world = build_mini(plan);
    VerifyOptions options;
    options.threads = 2;
    const auto open = [&] { return bytes_in_memory(world.bytes, "world"); };
    const VerifyReport all = verify_source(open, options);
    EXPECT_TRUE(all.ok());
    EXPECT_GT(all.census.zero_pages, 0u);
    EXPECT_EQ(all.decoded, all.census.refined);
    EXPECT_EQ(all.zero_skipped, 0u);
    options.zero_page_limit = 10;
    const VerifyReport some = verify_source(open, options);
    EXPECT_TRUE(some.ok());
    EXPECT_EQ(some.decoded, 10 * some.census.zero_pages);
    EXPECT_EQ(some.decoded + some.zero_skipped, some.census.refined);
    std::uint64_t told = 0;
    options = {};
    options.progress = [&](std::uint64_t, std::uint64_t) { return ++told < 3; };
    EXPECT_THROW(verify_source(open, options), Error) << "cancelled";
    EXPECT_EQ(told, 3u);
}

TEST_F(VerifyProgram, AFlippedBitAnywhereIsFound) {
    write_raster(path("hills.tif"), hills());
    ASSERT_EQ(carat("build -q --layer hills.tif --tolerance 2 -o a.carat").exit, 0);
    const std::uintmax_t size = fs::file_size(path("a.carat"));
    for (const std::uintmax_t at :
         {std::uintmax_t{3}, std::uintmax_t{30}, size / 4, size / 2, size - 40, size - 1}) {
        flip(path("a.carat"), at);
        const Outcome r = carat("verify --json a.carat");
        EXPECT_EQ(r.exit, 1) << "byte " << at;
        EXPECT_EQ(r.json().at("ok"), false) << "byte " << at;
        EXPECT_TRUE(contains(r.json().at("damage").at(0), "a.carat")) << r.out;
        flip(path("a.carat"), at);
    }
    EXPECT_EQ(carat("verify a.carat").exit, 0);
}

TEST_F(VerifyProgram, ATruncatedFileIsFound) {
    write_raster(path("hills.tif"), hills());
    ASSERT_EQ(carat("build -q --layer hills.tif --tolerance 2 -o a.carat").exit, 0);
    fs::resize_file(path("a.carat"), fs::file_size(path("a.carat")) - 1);
    const Outcome r = carat("verify a.carat");
    EXPECT_EQ(r.exit, 1);
    EXPECT_TRUE(contains(r.out, "damaged")) << r.out;
}

TEST_F(VerifyProgram, AgainstTheSourcesItMeasures) {
    write_raster(path("hills.tif"), hills());
    ASSERT_EQ(carat("build -q --layer hills.tif --valid-range -900,2000 --tolerance 2 -o a.carat").exit, 0);
    const Outcome text = carat("verify a.carat --against .");
    EXPECT_EQ(text.exit, 0) << text.err;
    EXPECT_TRUE(contains(text.out, "guaranteed at the file's own samples: 2 m")) << text.out;
    EXPECT_TRUE(contains(text.out, "worst in hills.tif")) << text.out;
    const auto by_folder = carat("verify --json a.carat --against .").json();
    const auto by_name = carat("verify --json a.carat --against hills.tif").json();
    EXPECT_EQ(by_folder.at("source_errors"), by_name.at("source_errors"));
    EXPECT_TRUE(by_name.at("source_remarks").empty());
    const auto& all = by_folder.at("source_errors").at("all");
    EXPECT_LT(all.at("samples"), 1024 * 512) << "the recorded valid range holds";
    EXPECT_GT(all.at("samples"), 1024 * 512 / 2);
    EXPECT_LE(all.at("p50_m"), all.at("p99_m"));
    EXPECT_LE(all.at("p99_m"), all.at("max_m"));
    const auto wider = carat("verify --json a.carat --against hills.tif --valid-range -5000,5000").json();
    EXPECT_EQ(wider.at("source_errors").at("all").at("samples"), 1024 * 512) << "options that are given win";
    EXPECT_TRUE(contains(carat("info a.carat").out, "error at source samples")) << "the build recorded it";
}

TEST_F(VerifyProgram, OtherSourcesAreRemarkedUpon) {
    write_raster(path("hills.tif"), hills());
    ASSERT_EQ(carat("build -q --layer hills.tif --tolerance 2 -o a.carat").exit, 0);
    write_raster(path("hills.tif"), flat(7));
    EXPECT_TRUE(
        contains(carat("verify a.carat --against hills.tif").out, "hills.tif: differs from the source"));
    EXPECT_TRUE(contains(carat("verify a.carat --against nowhere.tif").err, "nowhere.tif"));
    EXPECT_EQ(carat("verify a.carat --against nowhere.tif").exit, 1);
}

TEST_F(VerifyProgram, ACertificateIsConfirmedOrRefuted) {
    write_raster(path("hills.tif"), hills());
    ASSERT_EQ(carat("build -q --layer hills.tif --tolerance 2 --certify 3 -o a.carat").exit, 0);
    EXPECT_TRUE(
        contains(carat("info a.carat").out, "no source sample outside feathered zones is further than 3 m"));
    EXPECT_TRUE(contains(carat("verify a.carat --against .").out, "within 3 m: confirmed"));
    write_raster(path("hills.tif"), flat(7));
    const Outcome refuted = carat("verify a.carat --against hills.tif");
    EXPECT_TRUE(contains(refuted.out, "within 3 m: FALSE")) << refuted.out;
    EXPECT_EQ(refuted.exit, 1);
    write_raster(path("hills.tif"), hills());
    const Outcome limited =
        carat("build --layer hills.tif --max-level 2 --tolerance 2 --certify 2.001 -o b.carat");
    EXPECT_EQ(limited.exit, 3) << limited.err;
    EXPECT_TRUE(contains(limited.err, "no certificate")) << limited.err;
    EXPECT_TRUE(contains(carat("info b.carat").out, "certificate      none"));
}

// Files that no builder of ours writes, with checksums that fit.
class VerifyFile : public testing::Test {
  protected:
    using Change = std::function<void(std::vector<DiamondRecord>&)>;

    VerifyReport verify(const MiniBuild& b, const Change& change) const {
        std::vector<DiamondRecord> records;
        for (const DiamondId d : b.refined)
            records.push_back({d, b.residuals.at(d), {b.summary.at({d, 0}), b.summary.at({d, 1})}});
        change(records);
        WriterSetup setup;
        setup.coding = b.plan.coding;
        setup.log2_cells = b.plan.log2_cells;
        setup.quantum = b.plan.quantum;
        setup.tolerance = b.plan.tolerance;
        setup.body = b.plan.body;
        setup.radii.assign(b.levels.size(), b.radius);
        const fs::path file =
            fs::temp_directory_path() / ("carat-verify-" + std::to_string(getpid()) + ".carat");
        std::array<Grid, kFaces> roots;
        for (int face = 0; face < kFaces; ++face)
            roots[static_cast<std::size_t>(face)] = b.reference_p.at(root_diamond(face));
        RepositoryWriter writer(file, setup, encode_roots(roots, b.plan.n(), b.radius));
        writer.write(std::move(records));
        writer.finish();
        const VerifyReport report = verify_file(file);
        fs::remove(file);
        return report;
    }
    static MiniPlan plan(const Field& field, int depth) {
        MiniPlan p;
        p.source = field;
        p.depth = depth;
        return p;
    }
    static bool says(const VerifyReport& r, const std::string& what) {
        for (const std::string& d : r.damage)
            if (contains(d, what)) return true;
        return false;
    }
    static DiamondRecord& deepest(std::vector<DiamondRecord>& records) {
        return *std::max_element(records.begin(), records.end(),
                                 [](const auto& a, const auto& b) { return a.id.level() < b.id.level(); });
    }
};

TEST_F(VerifyFile, EveryFieldAndModePasses) {
    for (const Mode mode : {Mode::interpolating, Mode::filtered, Mode::paper})
        for (const NamedField& field : all_fields(50000, 24)) {
            MiniPlan p = plan(field.field, 4);
            p.mode = [mode](DiamondId) { return mode; };
            const MiniBuild b = build_mini(p);
            const VerifyReport r = verify(b, [](auto&) {});
            EXPECT_TRUE(r.ok()) << field.name << ": " << (r.damage.empty() ? "" : r.damage[0]);
            EXPECT_EQ(r.decoded, b.refined.size()) << field.name;
            EXPECT_EQ(r.census.refined, b.refined.size()) << field.name;
        }
}

// Marks "zero to level D" are counted by a formula and visited one by one: both must agree with the header.
TEST_F(VerifyFile, ZeroPagesAcrossBandsAreCountedAndVisited) {
    for (const int depth : {1, 2, 6, 7, 9}) {
        MiniPlan p = plan(constant(12345), depth);
        p.log2_cells = 2;
        const MiniBuild b = build_mini(p);
        const VerifyReport r = verify(b, [](auto&) {});
        EXPECT_TRUE(r.ok()) << depth << ": " << (r.damage.empty() ? "" : r.damage[0]);
        EXPECT_EQ(r.decoded, b.refined.size()) << depth;
        EXPECT_GT(r.census.zero_pages, 0u) << depth;
        for (std::size_t l = 0; l < r.census.levels.size(); ++l)
            EXPECT_EQ(r.census.levels[l].refined, kFaces * (std::uint64_t{1} << l)) << depth;
    }
}

TEST_F(VerifyFile, AMissingParentIsFound) {
    const MiniBuild b = build_mini(plan(fractal(20000), 3));
    const VerifyReport r = verify(b, [](std::vector<DiamondRecord>& records) {
        const DiamondId orphaned = *parent(deepest(records).id, 0);
        std::erase_if(records, [&](const DiamondRecord& d) { return d.id == orphaned; });
    });
    EXPECT_TRUE(says(r, "is refined, its parent"));
    EXPECT_GT(r.unreachable, 0u);
}

TEST_F(VerifyFile, ASummaryThatIsTooNarrowIsFound) {
    const MiniBuild b = build_mini(plan(fractal(20000), 3));
    const VerifyReport r = verify(b, [](std::vector<DiamondRecord>& records) {
        for (DiamondRecord& d : records)
            if (d.id == root_diamond(2)) d.summary[1].max = d.summary[1].min;
    });
    EXPECT_TRUE(
        says(r, "diamond " + to_string(root_diamond(2)) + " has heights outside the summaries of half 1"));
    EXPECT_FALSE(says(r, "diamond " + to_string(root_diamond(4)) + " has"));
}

// The leaf itself may be sound: its heights must lie within what every half above it says.
TEST_F(VerifyFile, ADeepHeightOutsideACoarseSummaryIsFound) {
    const DiamondId deep = child(child(root_diamond(0), 0), 0);
    const auto centre = deep.centre();
    MiniPlan p = plan([centre](const LatticePoint& q) { return q == centre ? 90000 : 0; }, 3);
    const MiniBuild b = build_mini(p);
    const VerifyReport sound = verify(b, [](auto&) {});
    ASSERT_TRUE(sound.ok()) << sound.damage[0];
    const VerifyReport r = verify(b, [](std::vector<DiamondRecord>& records) {
        for (DiamondRecord& d : records)
            if (d.id.level() == 0)
                for (SummaryValues& s : d.summary) s.max = std::min(s.max, 1000);
    });
    EXPECT_FALSE(r.ok());
}

TEST_F(VerifyFile, ResidualsThatDoNotDecodeAreFound) {
    const MiniBuild b = build_mini(plan(fractal(20000), 3));
    const VerifyReport r = verify(b, [](std::vector<DiamondRecord>& records) {
        auto& blob = deepest(records).residuals.blob;
        blob.resize(blob.size() / 2);
    });
    EXPECT_EQ(r.damage_count, 1u);
    EXPECT_EQ(r.unreachable, 1u);
}

TEST_F(VerifyFile, MemoryBoundAndThreadsDoNotMatter) {
    const MiniBuild b = build_mini(plan(fractal(20000), 5));
    const fs::path file =
        fs::temp_directory_path() / ("carat-threads-" + std::to_string(getpid()) + ".carat");
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(b.bytes.data()), static_cast<std::streamsize>(b.bytes.size()));
    VerifyOptions small;
    small.threads = 3;
    small.memory_bytes = 1;
    const VerifyReport one = verify_file(file), other = verify_file(file, small);
    fs::remove(file);
    EXPECT_TRUE(one.ok() && other.ok());
    EXPECT_EQ(one.heights, other.heights);
    EXPECT_EQ(one.decoded, other.decoded);
}

}  // namespace
}  // namespace carat::test
