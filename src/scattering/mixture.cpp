#include "scattering/mixture.h"

#include "base/error.h"

#include <algorithm>

namespace metrolux::core {
namespace {

using Part = MixtureParameters::Part;

class Mixture final : public Bsdf {
  public:
    Mixture(const std::vector<Part>& parts, float sum) : sum_(sum) {
        for (const Part& part : parts)
            if (part.weight > 0) parts_.push_back(part);
    }

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        float rest = uLobe * sum_;
        size_t i = 0;
        for (; i + 1 < parts_.size() && rest >= parts_[i].weight; ++i) rest -= parts_[i].weight;
        const Part& part = parts_[i];
        auto result = part.bsdf->sample(si, known, mode, std::min(rest / part.weight, kOneMinusEpsilon), u);
        if (!result) return std::nullopt;
        // A smooth sample stands for all models; a delta lobe belongs to one of them.
        if (!result->delta) return finishSmooth(si, known, result->direction, mode, result->eta);
        result->weight *= sum_;
        result->pdfForward *= part.weight / sum_;
        result->pdfReverse *= part.weight / sum_;
        return result;
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        BsdfEvaluation result;
        for (const Part& part : parts_) {
            const BsdfEvaluation e = part.bsdf->evaluate(si, wEye, wLight);
            result.value += e.value * part.weight;
            result.pdfLight += e.pdfLight * (part.weight / sum_);
            result.pdfEye += e.pdfEye * (part.weight / sum_);
        }
        return result;
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        Rgb result(0.0f);
        for (const Part& part : parts_) result += part.bsdf->albedo(si) * part.weight;
        return {std::min(result.x, 1.0f), std::min(result.y, 1.0f), std::min(result.z, 1.0f)};
    }
    bool hasSmoothLobe() const override {
        return any([](const Bsdf& b) { return b.hasSmoothLobe(); });
    }
    bool hasDeltaLobe() const override {
        return any([](const Bsdf& b) { return b.hasDeltaLobe(); });
    }
    bool isTransmissive() const override {
        return any([](const Bsdf& b) { return b.isTransmissive(); });
    }
    bool isDispersive() const override {
        return any([](const Bsdf& b) { return b.isDispersive(); });
    }
    bool isNarrow(const SurfaceInteraction& si) const override {
        return !any([&](const Bsdf& b) { return !b.isNarrow(si); });
    }

  private:
    template <class Predicate>
    bool any(Predicate&& predicate) const {
        return std::any_of(parts_.begin(), parts_.end(), [&](const Part& p) { return predicate(*p.bsdf); });
    }

    std::vector<Part> parts_;
    float sum_;
};

}  // namespace

BsdfPtr makeMixture(const MixtureParameters& parameters) {
    float sum = 0;
    for (const Part& part : parameters.parts) {
        if (!(part.weight >= 0)) throw Error("mixture: a weight is {}, expected 0 or more", part.weight);
        sum += part.weight;
    }
    if (!(sum > 0 && sum <= 1 + 1e-5f))
        throw Error("mixture: the sum of the weights is {}, expected one in (0, 1]", sum);
    return std::make_shared<Mixture>(parameters.parts, sum);
}

}  // namespace metrolux::core
