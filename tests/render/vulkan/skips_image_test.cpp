// What is skipped is not in the picture: drawn with each skip on and off from a real file, with the same cut,
// pictures are the same bit for bit, and the work with the skip is strictly less.
#include <array>
#include <map>

#include "carat/codec/file_contents.hpp"
#include "carat/codec/quantize.hpp"
#include "carat/globe/globe.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/render/patch_builder.hpp"
#include "file_planet.hpp"
#include "planet.hpp"

namespace carat::test {
namespace {

constexpr int kWidth = 96, kHeight = 64;

class Skips : public RendererTest {
  protected:
    Scratch scratch;
    std::filesystem::path file;
    std::vector<FileView> views;
    std::optional<Ellipsoid> body;
    Renderer* gpu = nullptr;

    void build(synth::Kind kind, double tolerance) {
        const FilePlanet planet = build_planet(kind, scratch.folder, tolerance);
        file = planet.file;
        body = Repository::open(file)->header().ellipsoid();
        views = file_views(planet, kWidth, kHeight);
    }
    // Refiners apart share no mesh, so what is drawn first is uploaded.
    Frame draw(const View& view, const MeshList& patches, bool skip_back = false) {
        if (gpu == nullptr) gpu = &renderer(*body, kFileCells);
        DrawRequest request = picture_request(view);
        request.skip_back_patches = skip_back;
        return gpu->draw(request, patches);
    }
    void expect_culled_unseen(bool of_frustum);
};

// The culled refined too, as far as their error asks for: what a frame without that skip would decode. Only
// diamonds both of whose halves are culled, which no other diamond needs: the rest of the cut stays.
class CulledRefined {
  public:
    CulledRefined(const std::shared_ptr<const Repository>& repository, const View& view, double threshold,
                  const MeshList& all, const MeshList& seen)
        : repository_(*repository),
          body_(repository->header().ellipsoid()),
          visibility_(visibility_of(repository->header(), body_, view, threshold, nullptr)),
          threshold_(threshold),
          builder_(body_, repository->header().quantum, kFileCells) {
        for (const auto& mesh : all) frontier_[mesh->half] = {mesh, true};
        for (const auto& mesh : seen) frontier_[mesh->half].culled = false;
        std::vector<DiamondId> open;
        for (const auto& [half, entry] : frontier_) open.push_back(half.diamond);
        while (!open.empty()) {
            const DiamondId d = open.back();
            open.pop_back();
            if (!demands(d)) continue;
            ++decoded_;
            for (const int side : {0, 1}) {
                frontier_.erase({d, side});
                for (const Half& child : child_halves({d, side})) {
                    frontier_[child] = {nullptr, true};
                    open.push_back(child.diamond);
                }
            }
        }
    }
    std::uint64_t decoded() const { return decoded_; }
    MeshList patches() {
        MeshList out;
        for (const auto& [half, entry] : frontier_)
            out.push_back(entry.mesh ? entry.mesh : builder_.build(half, heights_of(half)));
        return out;
    }

  private:
    struct Entry {
        std::shared_ptr<const PatchMesh> mesh;  // null: to be built
        bool culled = true;
    };
    bool demands(DiamondId d) const {
        double error = 0;
        for (const int side : {0, 1}) {
            const auto half = frontier_.find({d, side});
            if (half == frontier_.end() || !half->second.culled) return false;
        }
        if (!repository_.refined(d)) return false;
        for (const int side : {0, 1}) {
            const HalfSummary s = repository_.summary({d, side});
            const HalfVolume volume = half_volume(body_, {d, side}, s.min_height, s.max_height, s.delta);
            error = std::max(error, visibility_.screen_error(volume, s.delta));
        }
        return error > threshold_;
    }
    const RefinedHeights& refined(DiamondId d) {
        const auto [known, fresh] = refined_.try_emplace(d);
        if (!fresh) return known->second;
        Heights p{
            kFileCells + 1, std::vector<std::int32_t>((kFileCells + 1) * (kFileCells + 1)), {true, true}};
        if (d.level() == 0) {
            p = repository_.root(face_of(d.centre()));
        } else {
            for (const int side : {0, 1}) {
                const DiamondId up = *parent(d, side);
                gather_half(refined(up), up, {d, side}, p.values.data());
            }
        }
        RefinedHeights out;
        repository_.refine(d, p, out);
        return refined_[d] = std::move(out);
    }
    HalfHeights heights_of(const Half& half) {
        const DiamondId up = *parent(half.diamond, half.side);
        return gather_child(refined(up), up, half);
    }

    const Repository& repository_;
    Ellipsoid body_;
    Visibility visibility_;
    double threshold_;
    PatchBuilder builder_;
    std::map<Half, Entry> frontier_;
    std::map<DiamondId, RefinedHeights> refined_;
    std::uint64_t decoded_ = 0;
};

void Skips::expect_culled_unseen(bool of_frustum) {
    build(synth::Kind::earth, 5);
    std::uint64_t culled = 0, built = 0, extra = 0, bytes_on = 0, bytes_off = 0;
    int pictures = 0;
    for (const auto& [name, view, threshold] : views) {
        SCOPED_TRACE(name);
        const auto on = Repository::open(file), off = Repository::open(file);
        RefinerOptions options;
        options.threads = 1;  // two may read a page at once, each for itself
        Refiner skipping(on, options);
        const RefinedFrame least = skipping.frame(view, {threshold, 0});
        (of_frustum ? options.skip_frustum : options.skip_horizon) = false;
        Refiner whole(off, options);
        const RefinedFrame all = whole.frame(view, {threshold, 0});
        ASSERT_TRUE(least.converged && all.converged);
        EXPECT_EQ(all.counters.refined, least.counters.refined) << "the same cut";
        const std::uint64_t of_kind =
            of_frustum ? least.counters.culled_frustum : least.counters.culled_horizon;
        culled += of_kind;

        const Frame picture = draw(view, least.draw), undone = draw(view, all.draw);
        expect_same_pictures(undone, picture, "drawn nevertheless");
        EXPECT_EQ(undone.counters.patches_drawn - picture.counters.patches_drawn, of_kind);
        EXPECT_EQ(undone.counters.patches_uploaded - picture.counters.patches_uploaded, of_kind);
        EXPECT_GE(all.counters.built, least.counters.built);
        built += all.counters.built - least.counters.built;

        CulledRefined refined(off, view, threshold, all.draw, least.draw);
        const MeshList patches = refined.patches();
        expect_same_pictures(draw(view, patches), picture, "decoded and drawn nevertheless");
        extra += refined.decoded();
        bytes_on += on->counters().bytes;
        bytes_off += off->counters().bytes;
        EXPECT_LE(on->counters().bytes, off->counters().bytes);
        pictures += picture.counters.patches_drawn > 0;
        if (HasFailure()) return;
    }
    std::printf("%d pictures, %llu halves culled, %llu diamonds not decoded, %llu bytes of %llu read\n",
                pictures, static_cast<unsigned long long>(culled), static_cast<unsigned long long>(extra),
                static_cast<unsigned long long>(bytes_on), static_cast<unsigned long long>(bytes_off));
    EXPECT_GT(culled, 100u);
    EXPECT_GT(built, 100u);
    EXPECT_GT(extra, 100u);
    EXPECT_LT(bytes_on, bytes_off);
}

TEST_F(Skips, WhatIsOffTheScreen) { expect_culled_unseen(true); }
TEST_F(Skips, WhatIsBehindTheHorizon) { expect_culled_unseen(false); }

TEST_F(Skips, PatchesThatFaceAway) {
    build(synth::Kind::moon, 5);
    std::uint64_t back = 0;
    for (const auto& [name, view, threshold] : views) {
        SCOPED_TRACE(name);
        Refiner refiner(Repository::open(file));
        const RefinedFrame cut = refiner.frame(view, {threshold, 0});
        const Frame some = draw(view, cut.draw, true), all = draw(view, cut.draw);
        expect_same_pictures(some, all, "without backs");
        EXPECT_EQ(all.counters.patches_drawn, some.counters.patches_drawn + some.counters.patches_back);
        EXPECT_EQ(some.counters.patches_uploaded, some.counters.patches_drawn);
        EXPECT_EQ(all.counters.patches_uploaded, some.counters.patches_back) << "the backs come on top";
        EXPECT_EQ(all.counters.triangles - some.counters.triangles,
                  some.counters.patches_back * kFileCells * kFileCells);
        back += some.counters.patches_back;
    }
    std::printf("%llu patches that face away\n", static_cast<unsigned long long>(back));
    EXPECT_GT(back, 20u);
}

// The same file with its zeros spelt out: a blob for every diamond that stores none.
std::filesystem::path with_zeros_spelt_out(const std::filesystem::path& file) {
    const FileContents contents(file);
    const RepositoryHeader& h = contents.header();
    const auto repository = Repository::open(file);
    std::array<std::vector<std::int32_t>, kFaces> roots;
    for (int face = 0; face < kFaces; ++face)
        roots[static_cast<std::size_t>(face)] = repository->root(face).values;
    const std::int32_t radius = quantizer_radius(h.tolerance, h.quantum);
    WriterSetup setup;
    setup.log2_cells = h.log2_cells;
    setup.quantum = h.quantum;
    setup.tolerance = h.tolerance;
    setup.body = h.ellipsoid();
    setup.coding = contents.coding();
    setup.radii.assign(static_cast<std::size_t>(h.deepest_level) + 1, radius);
    std::vector<DiamondEntry> entries = contents.diamonds();
    for (DiamondEntry& e : entries) {
        if (e.blob_bytes > 0) continue;
        e.info.gamma = true;
        e.blob_bytes = 1;
    }
    std::filesystem::path out = file;
    out.replace_extension(".spelt.carat");
    RepositoryWriter writer(out, setup, encode_roots(roots, h.n(), radius));
    writer.write(entries, [&](std::size_t k, std::vector<std::byte>& blob) {
        contents.blob(k, blob);
        if (blob.empty()) blob.assign(1, std::byte{0});  // format.md, 8.3: the flag of a matrix of zeros
    });
    writer.finish();
    return out;
}

// Of diamonds without residuals nothing is stored, read or decoded.
TEST_F(Skips, DiamondsWithoutResiduals) {
    build(synth::Kind::earth, 300);
    const std::filesystem::path spelt = with_zeros_spelt_out(file);
    RefinerOptions options;
    options.threads = 1;  // two may read a page at once, each for itself
    RefineCounters least, whole;
    const auto add = [](RefineCounters& sum, const RefineCounters& c) {
        sum.refined += c.refined;
        sum.decoded += c.decoded;
        sum.predicted += c.predicted;
        sum.read.bytes += c.read.bytes;
    };
    for (const auto& [name, view, threshold] : views) {
        SCOPED_TRACE(name);
        Refiner skipping(Repository::open(file), options), decoding(Repository::open(spelt), options);
        const RefinedFrame some = skipping.frame(view, {threshold, 0}),
                           all = decoding.frame(view, {threshold, 0});
        expect_same_pictures(draw(view, all.draw), draw(view, some.draw), "zeros decoded");
        EXPECT_EQ(all.counters.refined, some.counters.refined);
        EXPECT_EQ(all.counters.predicted, 0u);
        EXPECT_EQ(all.counters.decoded, some.counters.decoded + some.counters.predicted);
        add(least, some.counters);
        add(whole, all.counters);
    }
    std::printf(
        "%llu diamonds decoded, %llu predicted, of %llu; %llu bytes of %llu read\n",
        static_cast<unsigned long long>(least.decoded), static_cast<unsigned long long>(least.predicted),
        static_cast<unsigned long long>(least.refined), static_cast<unsigned long long>(least.read.bytes),
        static_cast<unsigned long long>(whole.read.bytes));
    EXPECT_GT(least.decoded, 100u);
    EXPECT_GT(least.predicted, 100u);
    EXPECT_LT(least.decoded, whole.decoded);
    EXPECT_LT(least.read.bytes, whole.read.bytes);
}

// Every page of a file.
void read_all(const Repository& repository) {
    std::vector<DiamondId> open;
    for (int face = 0; face < kFaces; ++face) open.push_back(root_diamond(face));
    while (!open.empty()) {
        const DiamondId d = open.back();
        open.pop_back();
        if (!repository.refined(d)) continue;
        for (const DiamondId k : children(d))
            if (parent(k, 0) == d) open.push_back(k);
    }
}

TEST_F(Skips, PagesThatTheViewDoesNotNeed) {
    build(synth::Kind::earth, 5);
    const auto known = Repository::open(file);
    read_all(*known);
    const ReadCounters whole = known->counters();
    std::uint64_t bytes = 0, partial = 0;
    for (const auto& [name, view, threshold] : views) {
        SCOPED_TRACE(name);
        const auto fresh = Repository::open(file);
        Refiner refiner(fresh), informed(known);
        const RefinedFrame frame = refiner.frame(view, {threshold, 0}),
                           same = informed.frame(view, {threshold, 0});
        expect_same_pictures(draw(view, frame.draw), draw(view, same.draw), "all pages read before");
        EXPECT_EQ(same.counters.read.pages, 0u) << "they are all there";
        EXPECT_LE(fresh->counters().pages, whole.pages);
        EXPECT_LT(fresh->counters().bytes, fresh->file_bytes());
        bytes += fresh->counters().bytes;
        partial += fresh->counters().pages < whole.pages;
    }
    std::printf("%llu of %llu bytes read a view\n", static_cast<unsigned long long>(bytes / views.size()),
                static_cast<unsigned long long>(whole.bytes));
    EXPECT_EQ(partial, views.size());
    EXPECT_LT(bytes, views.size() * whole.bytes / 2);
}

}  // namespace
}  // namespace carat::test
