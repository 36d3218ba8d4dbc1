#include "image/filter.h"

#include "base/error.h"
#include "base/suggest.h"

namespace metrolux::core {
namespace {

constexpr int kCellsPerUnit = 256;
constexpr float kLargestRadius = 32;

double mitchellNetravali(double x, double b, double c) {
    // Mitchell & Netravali 1988, Reconstruction Filters in Computer Graphics, eq. 8.
    x = std::abs(x);
    if (x < 1) return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6;
    if (x < 2)
        return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x +
                (8 * b + 24 * c)) /
               6;
    return 0;
}

double sinc(double x) {
    if (std::abs(x) < 1e-6) return 1;
    return std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
}

float defaultRadius(ReconstructionFilter::Kind kind, const ReconstructionFilter::Parameters& parameters) {
    using Kind = ReconstructionFilter::Kind;
    switch (kind) {
        case Kind::Box:
            return 0.5f;
        case Kind::Tent:
            return 1;
        case Kind::Gaussian:
            return 4 * parameters.stddev;
        case Kind::Mitchell:
        case Kind::CatmullRom:
            return 2;
        case Kind::Lanczos:
            return static_cast<float>(parameters.lobes);
    }
    return 0.5f;
}

double filterValue(ReconstructionFilter::Kind kind, const ReconstructionFilter::Parameters& parameters,
                   double radius, double x) {
    using Kind = ReconstructionFilter::Kind;
    switch (kind) {
        case Kind::Box:
            return 1;
        case Kind::Tent:
            return std::max(0.0, 1 - std::abs(x) / radius);
        case Kind::Gaussian: {
            const double alpha = -1 / (2 * sqr(static_cast<double>(parameters.stddev)));
            return std::max(0.0, std::exp(alpha * x * x) - std::exp(alpha * radius * radius));
        }
        // The cubics are defined for radius 2; another radius stretches them.
        case Kind::Mitchell:
            return mitchellNetravali(2 * x / radius, parameters.b, parameters.c);
        case Kind::CatmullRom:
            return mitchellNetravali(2 * x / radius, 0, 0.5);
        case Kind::Lanczos:
            return sinc(x) * sinc(x / radius);
    }
    return 0;
}

/// Value of a piecewise-linear cumulative table at a position in cells.
double interpolate(const std::vector<double>& cdf, double position) {
    const size_t cell = std::min(static_cast<size_t>(position), cdf.size() - 2);
    return std::lerp(cdf[cell], cdf[cell + 1], position - static_cast<double>(cell));
}

}  // namespace

ReconstructionFilter::ReconstructionFilter(Kind kind, const Parameters& parameters) : kind_(kind) {
    if (kind == Kind::Gaussian && !(parameters.stddev > 0))
        throw Error("reconstruction filter: stddev is {}, expected a positive number", parameters.stddev);
    if (kind == Kind::Lanczos && parameters.lobes < 1)
        throw Error("reconstruction filter: {} lobes, expected at least 1", parameters.lobes);
    radius_ = parameters.radius != 0 ? parameters.radius : defaultRadius(kind, parameters);
    if (!(radius_ > 0) || radius_ > kLargestRadius)
        throw Error("reconstruction filter: radius is {}, expected 0 < radius <= {} pixels", radius_,
                    kLargestRadius);

    const int cells = std::max(2, 2 * static_cast<int>(std::ceil(radius_ * kCellsPerUnit)));
    const double cellWidth = 2.0 * radius_ / cells;
    table_.resize(cells);
    signedCdf_.assign(cells + 1, 0);
    absCdf_.assign(cells + 1, 0);
    for (int i = 0; i < cells; ++i) {
        const double x = (i + 0.5 - 0.5 * cells) * cellWidth;
        table_[i] = static_cast<float>(filterValue(kind, parameters, radius_, x));
        signedCdf_[i + 1] = signedCdf_[i] + table_[i] * cellWidth;
        absCdf_[i + 1] = absCdf_[i] + std::abs(table_[i]) * cellWidth;
    }
    guide_.resize(static_cast<size_t>(cells));
    uint32_t cell = 0;
    for (int i = 0; i < cells; ++i) {
        const double target = absCdf_.back() * i / cells;
        while (cell + 1 < static_cast<uint32_t>(cells) && absCdf_[cell + 1] < target) ++cell;
        guide_[i] = cell;
    }
    // Half of the support on each side of the center is always inside the image.
    if (!(signedCdf_.back() > 0)) throw Error("reconstruction filter: its integral is not positive");
}

ReconstructionFilter::Cut ReconstructionFilter::cut(int pixel, int size) const {
    const double cellsPerPixel = static_cast<double>(table_.size()) / (2.0 * radius_);
    const double center = pixel + 0.5;
    const double cells = static_cast<double>(table_.size());
    return {std::clamp((radius_ - center) * cellsPerPixel, 0.0, cells),
            std::clamp((radius_ + size - center) * cellsPerPixel, 0.0, cells)};
}

float ReconstructionFilter::sample(int pixel, int size, float u, float& weight) const {
    Cut range{0, static_cast<double>(table_.size())};
    double absLower = 0, absUpper = absCdf_.back(), integral = signedCdf_.back();
    if (!isInside(static_cast<float>(pixel) + 0.5f, size)) {
        range = cut(pixel, size);
        absLower = interpolate(absCdf_, range.lower), absUpper = interpolate(absCdf_, range.upper);
        integral = interpolate(signedCdf_, range.upper) - interpolate(signedCdf_, range.lower);
    }
    const double target = std::lerp(absLower, absUpper, static_cast<double>(u));
    const auto share = static_cast<size_t>(target / absCdf_.back() * static_cast<double>(guide_.size()));
    size_t cell = guide_[std::min(share, guide_.size() - 1)];
    while (cell + 2 < absCdf_.size() && absCdf_[cell + 1] <= target) ++cell;
    const double inCell = absCdf_[cell + 1] - absCdf_[cell];
    const double fraction = inCell > 0 ? (target - absCdf_[cell]) / inCell : 0.5;
    const double position = std::clamp(static_cast<double>(cell) + fraction, range.lower, range.upper);

    const double sign = table_[cell] < 0 ? -1 : 1;
    weight *= static_cast<float>(sign * (absUpper - absLower) / integral);
    const double x = pixel + 0.5 + (position / static_cast<double>(table_.size()) * 2 - 1) * radius_;
    return std::clamp(static_cast<float>(x), 0.0f, static_cast<float>(size));
}

double ReconstructionFilter::squaredWeights() const {
    double squares = 0;
    for (const float h : table_) squares += sqr(double(h));
    const double ofAxis = squares * 2 * radius_ / double(table_.size()) / sqr(signedCdf_.back());
    return sqr(ofAxis);
}

float ReconstructionFilter::evaluate(int pixel, int size, float x) const {
    const float center = static_cast<float>(pixel) + 0.5f;
    const float scale = static_cast<float>(table_.size()) / (2 * radius_);
    const float position = (x - center + radius_) * scale;
    if (!(position >= 0) || position >= static_cast<float>(table_.size()) || !(x >= 0) ||
        x > static_cast<float>(size))
        return 0;
    const float h = table_[static_cast<size_t>(position)];
    if (isInside(center, size)) return h / static_cast<float>(signedCdf_.back());
    const Cut range = cut(pixel, size);
    return h /
           static_cast<float>(interpolate(signedCdf_, range.upper) - interpolate(signedCdf_, range.lower));
}

const std::vector<std::pair<std::string, ReconstructionFilter::Kind>>& filterNames() {
    using Kind = ReconstructionFilter::Kind;
    static const std::vector<std::pair<std::string, Kind>> names{{"box", Kind::Box},
                                                                 {"tent", Kind::Tent},
                                                                 {"gaussian", Kind::Gaussian},
                                                                 {"mitchell", Kind::Mitchell},
                                                                 {"catmullrom", Kind::CatmullRom},
                                                                 {"lanczos", Kind::Lanczos}};
    return names;
}

const std::string& filterName(ReconstructionFilter::Kind kind) {
    for (const auto& [name, k] : filterNames())
        if (k == kind) return name;
    throw Error("reconstruction filter {} has no name", static_cast<int>(kind));
}

ReconstructionFilter::Kind filterKind(const std::string& name) {
    std::vector<std::string> known;
    for (const auto& [candidate, kind] : filterNames()) {
        if (candidate == name) return kind;
        known.push_back(candidate);
    }
    const std::string near = nearestName(name, known);
    throw Error("unknown reconstruction filter '{}'{}; known: {}", name,
                near.empty() ? "" : fmt::format(", did you mean '{}'?", near), fmt::join(known, ", "));
}

}  // namespace metrolux::core
