#include "base/error.h"
#include "media/phase_function.h"

#include <vector>

namespace metrolux::core {
namespace {

constexpr float kInvFourPi = 0.25f * kInvPi;

class Isotropic final : public PhaseFunction {
  public:
    float evaluate(const Vec3f&, float) const override { return kInvFourPi; }
    Sample sample(const Vec3f&, float, float u) const override { return {1 - 2 * u, kInvFourPi}; }
};

class HenyeyGreenstein final : public PhaseFunction {
  public:
    explicit HenyeyGreenstein(float g) : g_(g) {}
    float evaluate(const Vec3f&, float cosine) const override {
        // 1 + g^2 - 2 g cosine, which would cancel where the function peaks.
        const float d = sqr(1 - std::abs(g_)) + 2 * std::abs(g_) * (1 - std::copysign(1.0f, g_) * cosine);
        return kInvFourPi * (1 - g_) * (1 + g_) / (d * std::sqrt(d));
    }
    Sample sample(const Vec3f& p, float, float u) const override {
        float cosine = 1 - 2 * u;
        if (std::abs(g_) > 1e-3f) {  // below, the inversion cancels
            const double g = g_, s = (1 - g * g) / (1 + g - 2 * g * u);
            cosine = static_cast<float>(std::clamp((1 + g * g - s * s) / (2 * g), -1.0, 1.0));
        } else {
            cosine += 1.5f * g_ * (1 - cosine * cosine);  // to first order in g
        }
        return {cosine, evaluate(p, cosine)};
    }

  private:
    float g_;
};

class Rayleigh final : public PhaseFunction {
  public:
    float evaluate(const Vec3f&, float cosine) const override {
        return 0.1875f * kInvPi * (1 + cosine * cosine);
    }
    Sample sample(const Vec3f& p, float, float u) const override {
        // The inverse of its distribution, which is a cubic in the cosine (Frisvad 2011).
        const double z = 2 * (2.0 * double(u) - 1), a = std::cbrt(z + std::sqrt(z * z + 1));
        const auto cosine = static_cast<float>(std::clamp(a - 1 / a, -1.0, 1.0));
        return {cosine, evaluate(p, cosine)};
    }
};

class Tabulated final : public PhaseFunction {
  public:
    explicit Tabulated(std::span<const float> values) : step_(2.0 / double(values.size() - 1)) {
        double sum = 0;
        cumulative_.push_back(0);
        for (size_t i = 0; i + 1 < values.size(); ++i) {
            sum += 0.5 * step_ * (double(values[i]) + values[i + 1]);
            cumulative_.push_back(sum);
        }
        for (const float value : values) values_.push_back(value / sum);
        for (double& c : cumulative_) c /= sum;
    }
    float evaluate(const Vec3f&, float cosine) const override { return density(cosine); }
    Sample sample(const Vec3f&, float, float u) const override {
        // The interval, the last that begins at or below u; then the root of a quadratic in it.
        const auto above = std::upper_bound(cumulative_.begin(), cumulative_.end() - 1, double(u));
        const auto i = static_cast<size_t>(above - cumulative_.begin()) - 1;
        const double rest = u - cumulative_[i], a = values_[i], b = values_[i + 1];
        // a x + (b - a) / (2 step) x^2 = rest, in the form that does not cancel
        const double root = std::sqrt(std::max(a * a + 2 * (b - a) / step_ * rest, 0.0));
        const double x = rest > 0 ? 2 * rest / (a + root) : 0.0;
        const auto cosine =
            static_cast<float>(std::clamp(-1 + double(i) * step_ + std::min(x, step_), -1.0, 1.0));
        return {cosine, density(cosine)};
    }

  private:
    float density(float cosine) const {
        const double position = std::clamp((double(cosine) + 1) / step_, 0.0, double(values_.size() - 1));
        const auto i = std::min(static_cast<size_t>(position), values_.size() - 2);
        const double x = position - double(i);
        return static_cast<float>((values_[i] + x * (values_[i + 1] - values_[i])) *
                                  (0.5 / std::numbers::pi));
    }

    double step_;
    std::vector<double> values_;      ///< densities over the cosine
    std::vector<double> cumulative_;  ///< their integral up to each
};

class Blend final : public PhaseFunction {
  public:
    Blend(PhaseFunctionPtr first, PhaseFunctionPtr second, VolumePtr weight)
        : first_(std::move(first)), second_(std::move(second)), weight_(std::move(weight)) {}
    float evaluate(const Vec3f& p, float cosine) const override {
        return lerp(weightAt(p), first_->evaluate(p, cosine), second_->evaluate(p, cosine));
    }
    Sample sample(const Vec3f& p, float uLobe, float u) const override {
        const float weight = weightAt(p);
        const bool isSecond = uLobe < weight;
        // What is left of uLobe picks within the part.
        const float inside = isSecond ? uLobe / weight : (uLobe - weight) / (1 - weight);
        const PhaseFunction& part = isSecond ? *second_ : *first_;
        const float cosine = part.sample(p, std::min(inside, kOneMinusEpsilon), u).cosine;
        return {cosine, evaluate(p, cosine)};
    }

  private:
    float weightAt(const Vec3f& p) const { return std::clamp(luminance(weight_->value(p)), 0.0f, 1.0f); }

    PhaseFunctionPtr first_, second_;
    VolumePtr weight_;
};

}  // namespace

PhaseFunctionPtr makeIsotropicPhase() { return std::make_shared<Isotropic>(); }

PhaseFunctionPtr makeHenyeyGreensteinPhase(float g) {
    if (!(g > -1 && g < 1)) throw Error("hg: the mean cosine g is {}, expected one in (-1, 1)", g);
    return std::make_shared<HenyeyGreenstein>(g);
}

PhaseFunctionPtr makeRayleighPhase() { return std::make_shared<Rayleigh>(); }

PhaseFunctionPtr makeTabulatedPhase(std::span<const float> values) {
    if (values.size() < 2) throw Error("tabphase: found {} values, expected two at least", values.size());
    bool isZero = true;
    for (size_t i = 0; i < values.size(); ++i) {
        if (!(values[i] >= 0) || !std::isfinite(values[i]))
            throw Error(
                "tabphase: value {} (counted from 0) is {}, expected a finite number that is not negative", i,
                values[i]);
        isZero = isZero && values[i] == 0;
    }
    if (isZero) throw Error("tabphase: all values are 0, expected one that is larger");
    return std::make_shared<Tabulated>(values);
}

PhaseFunctionPtr makeBlendPhase(PhaseFunctionPtr first, PhaseFunctionPtr second, VolumePtr weight) {
    const float most = luminance(weight->maximum());
    // Rounded sums of luminance may exceed 1 where all channels are 1.
    if (!(most <= 1.0001f)) throw Error("blendphase: found a weight of {}, expected weights in [0, 1]", most);
    return std::make_shared<Blend>(std::move(first), std::move(second), std::move(weight));
}

}  // namespace metrolux::core
