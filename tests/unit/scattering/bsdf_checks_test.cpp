/// The common checks find faults: models that are wrong in one respect each.
#include "bsdf_checks.h"

#include "base/warp.h"

#include <gtest/gtest-spi.h>

namespace metrolux::core::test {
namespace {

/// White diffuse reflection and a mirror, half and half, with a choice of faults.
struct Faults {
    float density = 1;       ///< factor of the density that evaluate() claims
    float value = 1;         ///< factor of the value
    float weight = 1;        ///< factor of the weight of smooth samples
    float asymmetry = 0;     ///< the value depends on the light's azimuth only
    float reverse = 0.5f;    ///< claimed probability of the mirror from its other end
    float mirrorWeight = 1;  ///< factor of the mirror's energy for light subpaths
};

class Faulty final : public Bsdf {
  public:
    explicit Faulty(const Faults& faults) : f_(faults) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        if (!(known.z > 0)) return std::nullopt;
        if (uLobe < 0.5f) {
            auto s = finishSmooth(si, known, warp::squareToCosineHemisphere(u), mode);
            if (s) s->weight *= f_.weight;
            return s;
        }
        BsdfSample s;
        s.delta = true;
        s.direction = reflectLocal(known);
        s.pdfForward = 0.5f;
        s.pdfReverse = f_.reverse;
        s.weight = Rgb(mode == TransportMode::Importance ? f_.mirrorWeight : 1.0f);
        return s;
    }
    BsdfEvaluation evaluate(const SurfaceInteraction&, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!(wEye.z > 0 && wLight.z > 0)) return {};
        const float scale = 0.5f * f_.density;
        return {Rgb(0.5f * f_.value * kInvPi * wLight.z * (1 + f_.asymmetry * wLight.x)),
                scale * warp::cosineHemispherePdf(wLight), scale * warp::cosineHemispherePdf(wEye)};
    }
    Rgb albedo(const SurfaceInteraction&) const override { return Rgb(1.0f); }
    bool hasSmoothLobe() const override { return true; }
    bool hasDeltaLobe() const override { return true; }

  private:
    Faults f_;
};

using Check = std::function<void(const BsdfCase&, const Vec3f&, TransportMode)>;

/// Number of failures that a check reports for a model, in both modes together.
int failures(const Faults& faults, const Check& check) {
    ::testing::TestPartResultArray results;
    {
        ::testing::ScopedFakeTestPartResultReporter reporter(&results);
        const BsdfCase c{"faulty", std::make_shared<Faulty>(faults)};
        for (const TransportMode mode : {TransportMode::Radiance, TransportMode::Importance})
            check(c, normalize(Vec3f(0.3f, 0.1f, 0.8f)), mode);
    }
    return results.size();
}

TEST(BsdfChecks, FindFaults) {
    const Check sampling = [](const auto& c, const auto& known, auto mode) {
        checkSampling(c, known, mode, 1);
    };
    const Check evaluation = [](const auto& c, const auto& known, auto mode) {
        checkEvaluation(c, known, mode, 1, 20);
    };
    const Check energy = [](const auto& c, const auto& known, auto mode) { checkEnergy(c, known, mode, 1); };
    const Check delta = [](const auto& c, const auto& known, auto mode) { checkDelta(c, known, mode, 1); };
    for (const Check& check : {sampling, evaluation, energy, delta}) EXPECT_EQ(failures({}, check), 0);

    Faults faults;
    faults.density = 0.9f;
    EXPECT_GT(failures(faults, sampling), 0);
    faults = {};
    faults.weight = 1.01f;
    EXPECT_GT(failures(faults, evaluation), 0);
    faults = {};
    faults.asymmetry = 0.2f;
    EXPECT_GT(failures(faults, evaluation), 0);
    faults = {};
    faults.value = 1.1f;
    EXPECT_GT(failures(faults, energy), 0);
    faults = {};
    faults.reverse = 0.45f;
    EXPECT_GT(failures(faults, delta), 0);
    faults = {};
    faults.mirrorWeight = 0.9f;
    EXPECT_GT(failures(faults, delta), 0);
}

}  // namespace
}  // namespace metrolux::core::test
