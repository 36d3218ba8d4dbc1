#include "base/error.h"
#include "media/phase_function.h"

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
        const float d = 1 + g_ * g_ - 2 * g_ * cosine;
        return kInvFourPi * (1 - g_ * g_) / (d * std::sqrt(d));
    }
    Sample sample(const Vec3f& p, float, float u) const override {
        float cosine = 1 - 2 * u;
        if (std::abs(g_) > 1e-3f) {  // below, the inversion cancels
            const float s = (1 - g_ * g_) / (1 + g_ - 2 * g_ * u);
            cosine = std::clamp((1 + g_ * g_ - s * s) / (2 * g_), -1.0f, 1.0f);
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

}  // namespace

PhaseFunctionPtr makeIsotropicPhase() { return std::make_shared<Isotropic>(); }

PhaseFunctionPtr makeHenyeyGreensteinPhase(float g) {
    if (!(g > -1 && g < 1)) throw Error("hg: the mean cosine g is {}, expected one in (-1, 1)", g);
    return std::make_shared<HenyeyGreenstein>(g);
}

PhaseFunctionPtr makeRayleighPhase() { return std::make_shared<Rayleigh>(); }

}  // namespace metrolux::core
