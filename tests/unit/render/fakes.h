#pragma once
#include "integrators/resumable.h"

#include <nlohmann/json.hpp>

#include <functional>

namespace metrolux::core::test {

/// Gives every pixel of pass i the value `values(i)`.
class FakeIntegrator final : public Resumable<FakeIntegrator> {
  public:
    explicit FakeIntegrator(std::function<float(uint32_t)> values = [](uint32_t) { return 1.0f; })
        : values_(std::move(values)) {}
    void addPass(Film& film, uint32_t pass) override {
        const float value = values_(pass);
        for (int i = 0; i < film.pixelCount(); ++i)
            film.addEye(static_cast<uint32_t>(i), Rgb(value, 0, 2 * value));
    }
    template <class Archive>
    void serialize(Archive&) {}
    nlohmann::json statistics() const override { return {{"fake", true}}; }
    std::string progressNote() const override { return "a note"; }

  private:
    std::function<float(uint32_t)> values_;
};

}  // namespace metrolux::core::test
