#include "render/slices.h"

#include "fakes.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

/// Notes the numbers of its passes; each leaves out a contribution of next-event estimation and one that the
/// film refuses.
class CountingIntegrator final : public Resumable<CountingIntegrator> {
  public:
    explicit CountingIntegrator(std::vector<uint32_t>& passes) : passes_(passes) {}
    void addPass(Film& film, uint32_t pass) override {
        passes_.push_back(pass);
        nonFinite_.reject(Rgb(kInfinity), Technique::Nee);
        film.addEye(0, Rgb(kInfinity));
    }
    template <class Archive>
    void serialize(Archive&) {}
    nlohmann::json statistics() const override { return nlohmann::json::object(); }

  private:
    std::vector<uint32_t>& passes_;
};

TEST(Slices, NumberTheirOwnPassesAndCountForAll) {
    std::vector<uint32_t> passes;
    SlicedIntegrator integrator([&](uint32_t) { return std::make_unique<CountingIntegrator>(passes); },
                                  {3, 0, 2});
    integrator.setTotalPasses(7);
    Film film({2, 2, 0, 0, 2, 2}, ReconstructionFilter(ReconstructionFilter::Kind::Box, {}));
    for (uint32_t pass = 0; pass < 7; ++pass) integrator.renderPass(film, pass);
    EXPECT_EQ(passes, (std::vector<uint32_t>{0, 1, 2, 0, 1, 0, 1}));
    EXPECT_EQ(film.passes(), 7u);
    EXPECT_EQ(integrator.nonFinite(), (TechniqueCounts{7, 7, 0, 0, 0}));
}

}  // namespace
}  // namespace metrolux::core
