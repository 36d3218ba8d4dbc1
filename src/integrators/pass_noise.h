#pragma once
#include "integrators/pixel_importance.h"
#include "transport/eye_factors.h"
#include "transport/eye_tail.h"

#include <vector>

namespace metrolux::core {

/// What a pass has done: a measure of its time that is the same on every machine.
struct PassWork {
    uint64_t eyeVertices = 0, lightVertices = 0, connections = 0, merges = 0;

    /// Time of the pass's eye subpaths, were they alone, over that of the whole pass.
    double eyeShare() const;
    void add(const PassWork& other);
    template <class Archive>
    void serialize(Archive& archive) {
        archive(eyeVertices, lightVertices, connections, merges);
    }
};

/// Compares passes that have light subpaths with what their eye subpaths would be alone, by work and by noise
/// relative to the image. Noise is the difference between the first half of the passes and the rest: the eye
/// subpaths' low-discrepancy points make less than single passes tell. Where the passes are too few, or of
/// several kinds, it is that between one judged pass and the next.
class PassNoise {
  public:
    explicit PassNoise(size_t pixels) : pixels_(pixels), eyeSums_(pixels) {}

    /// The pass to come is judged, which is made of so many iterations. It is compared with those before if
    /// they are of the same kind.
    void begin(const EyeFactors& eyes, const PixelImportance& importance, uint8_t kind, int iterations);
    /// The eye subpaths of a pass, judged or not, have been traced.
    void addEyes(const EyeFactors& eyes);
    /// Half of the passes have been made (LightSubpathChoice::halfWay()).
    void noteHalf(const OwnImage& image);
    /// The judged pass has been made.
    void close(const OwnImage& image, const PassWork& work);
    /// No more passes are judged for now.
    void end();
    bool open() const { return open_; }
    /// Of what eye subpaths have found until begin().
    const EyeTail& tail() const { return tail_; }

    /// Variances of a pass's pixels, mean over the film, relative to the image.
    struct Verdict {
        double noise = 0, aloneNoise = 0;        ///< without the worst pixels, as errors are compared
        double allNoise = 0, aloneAllNoise = 0;  ///< with them
        Surprise surprise;                       ///< what these lack, because no eye subpath has met it yet
        double eyeShare = 1;                     ///< PassWork::eyeShare()
        /// Of eye subpaths alone in the same time, over what they may at most have to be chosen. 1 before it
        /// is known.
        double lossOfAlone() const;
        template <class Archive>
        void serialize(Archive& archive) {
            archive(noise, aloneNoise, allNoise, aloneAllNoise, surprise, eyeShare);
        }
    };
    /// Of the passes so far, all of which have had light subpaths if `uniform`. `surprise`: sum of
    /// EyeTail::surprise() in a pass.
    Verdict verdict(const OwnImage& image, const PixelImportance& importance, bool uniform,
                    const Surprise& surprise) const;

    /// Between two passes.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(kind_, comparable_, differences_, eyeDifferences_, halfPasses_, work_);
        for (std::vector<float>* values : {&last_, &squares_, &eyeSquares_})
            serializeIfThere(archive, *values);
        serializeIfThere(archive, halfShown_);
        serializeIfThere(archive, halfEyeSums_);
        serializeElements(archive, eyeSums_, "pixels");
        checkState(halfPasses_ == 0 || !(halfShown_.empty() || halfEyeSums_.empty()),
                   "sums of half the passes");
    }

  private:
    /// A value of each pixel, or none.
    template <class Archive, class T>
    void serializeIfThere(Archive& archive, std::vector<T>& values) const {
        serializeAtMost(archive, values, pixels_, "pixels");
        checkState(values.empty() || values.size() == pixels_, "noise of all pixels");
    }

    size_t pixels_;
    EyeTail tail_;
    bool open_ = false;  ///< a judged pass has begun
    uint8_t kind_ = 0;
    bool comparable_ = false;  ///< the pass before is judged too, of its kind, and in last_
    uint32_t differences_ = 0, eyeDifferences_ = 0;
    uint32_t halfPasses_ = 0;  ///< at noteHalf()
    PassWork work_;
    // Luminances of each pixel, while passes are judged.
    std::vector<float> last_;                  ///< the pass before
    std::vector<float> squares_, eyeSquares_;  ///< sums of half the squared differences
    // Of each pixel, always.
    std::vector<double> halfShown_, halfEyeSums_;  ///< sums at noteHalf(), of the image and of eye subpaths
    std::vector<double> eyeSums_;
};

}  // namespace metrolux::core
