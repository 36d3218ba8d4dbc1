#pragma once
#include "base/math.h"
#include "base/state.h"
#include "image/exact_sum.h"
#include "image/film_window.h"
#include "image/filter.h"
#include "image/splat.h"

#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

namespace metrolux::core {

/// A rectangle of raster positions, in pixels of the full image.
struct RasterRectangle {
    Vec2f lower, upper;
    float area() const { return (upper.x - lower.x) * (upper.y - lower.y); }
    bool contains(const Vec2f& p) const {
        return p.x >= lower.x && p.x <= upper.x && p.y >= lower.y && p.y <= upper.y;
    }
    /// Point of the rectangle, from the unit square.
    Vec2f at(const Vec2f& u) const {
        return {lower.x + u.x * (upper.x - lower.x), lower.y + u.y * (upper.y - lower.y)};
    }
};

/// Accumulates an image pass by pass. The result does not depend on the order of calls within a pass:
/// eye contributions of a pixel come from one task, splats are summed in fixed point.
class Film {
  public:
    /// What is added counts 2^exponent: images and variances are in the units of the scene.
    Film(const FilmWindow& window, const ReconstructionFilter& filter, int exponent = 0);

    const FilmWindow& window() const { return window_; }
    const ReconstructionFilter& filter() const { return filter_; }
    int width() const { return window_.width; }
    int height() const { return window_.height; }
    int pixelCount() const { return window_.pixelCount(); }

    /// Raster position (pixels of the full image) for the eye subpath of pixel `pixel` (index in the window),
    /// drawn from the reconstruction filter; `weight` is the filter's sign and normalization, to be
    /// multiplied into the subpath's throughput.
    Vec2f samplePosition(uint32_t pixel, const Vec2f& u, float& weight) const;

    /// The raster positions whose splats reach a pixel of the window: the window and the filter's radius
    /// around it, within the image.
    RasterRectangle reach() const;

    /// Adds to a pixel what its own eye subpath found. One task per pixel; not atomic.
    void addEye(uint32_t pixel, const Rgb& value);
    /// Adds scale * splats of a light subpath. Thread-safe and order-independent (fixed point, 64 bits).
    void addSplats(const SplatList& splats, double scale);
    /// As addSplats with another factor for film splats than for pixel splats.
    void addSplats(const SplatList& splats, double pixelScale, double filmScale);

    /// Luminance of what the pass under way has added to a pixel so far. Films are shared by slices; this is
    /// one integrator's own.
    double passLuminance(size_t pixel) const;

    /// Numbers of values that were not added, as they were not finite or too large for a sum.
    struct LeftOut {
        uint64_t pixels = 0;       ///< by addEye(), and of whole pixels by endPass()
        uint64_t pixelSplats = 0;  ///< by addSplats()
        uint64_t filmSplats = 0;
    };
    /// Closes a pass: adds it to the running sums, updates the per-pixel variance and the error estimate.
    /// Says what of the pass was left out.
    LeftOut endPass();
    uint32_t passes() const { return passes_; }
    int exponent() const { return exponent_; }
    /// Values of image() that are too large for single precision, or so small that it loses bits of them.
    uint64_t beyondFloat() const;
    /// BlockedErrorEstimate has room for no more, and loadState() takes no more.
    static constexpr uint32_t kMostPasses = (uint32_t{1} << 24) - 1;

    /// Mean over passes, row by row, 3 floats a pixel. What single precision cannot hold is its largest
    /// number, and is counted by beyondFloat().
    std::vector<float> image() const;
    /// As image(), into memory for it.
    void image(std::span<float> target) const;
    /// Variance of the mean of the luminance of each pixel, from the differences between passes. For
    /// chain-based integrators passes are correlated and this is too small: see relativeError().
    std::vector<float> variance() const;
    void variance(std::span<float> target) const;
    /// Estimated root of the mean squared relative error of the image, from a fixed subset of pixels and
    /// blocked (Flyvbjerg & Petersen 1989) pass means, which holds for correlated passes too. Infinity before
    /// it is known.
    double relativeError() const;

    /// Everything between two passes. loadState() throws Error unless it is that of a film of this size.
    void saveState(StateWriter& writer) const;
    void loadState(StateReader& reader);
    /// Adds the passes of another film of the same window. Sums are exact: in any order and grouping they
    /// give the same bits. relativeError() is not known for the result.
    void add(const Film& other);
    std::span<const PixelSum> sums() const;
    /// As add(), of a film that has these sums and counts.
    void addSums(std::span<const PixelSum> sums, uint32_t passes);

  private:
    template <class Archive>
    void serialize(Archive& archive);
    struct Implementation;
    FilmWindow window_;
    ReconstructionFilter filter_;
    int exponent_;
    uint32_t passes_ = 0;
    std::shared_ptr<Implementation> implementation_;
};

}  // namespace metrolux::core
