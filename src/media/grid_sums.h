#pragma once
#include "media/grid_cell.h"

#include <optional>

namespace metrolux::core {

/// Samples at the corners of the cells of a run.
template <int Channels>
struct RunSamples {
    float corner[Channels][kCorners][CellRun::kMost];
};

/// Integrals over the cells of a run, of one channel.
inline void integrate(const CellRun& run, const LatticeRay& ray,
                      const float (&corner)[kCorners][CellRun::kMost], double (&parts)[CellRun::kMost]) {
    for (int i = 0; i < run.padded; ++i) {
        const double middle = 0.5 * (run.distance[i] + run.distance[i + 1]),
                     half = 0.5 * (run.distance[i + 1] - run.distance[i]);
        const auto at = [&](double t) {
            const float c[kCorners] = {corner[0][i], corner[1][i], corner[2][i], corner[3][i],
                                       corner[4][i], corner[5][i], corner[6][i], corner[7][i]};
            return trilinear(c, static_cast<float>(ray.origin.x + ray.direction.x * t - run.x[i]),
                             static_cast<float>(ray.origin.y + ray.direction.y * t - run.y[i]),
                             static_cast<float>(ray.origin.z + ray.direction.z * t - run.z[i]));
        };
        const float sum = at(middle - kGauss * half) + at(middle + kGauss * half);
        // Rounding may take a value below 0 where samples are 0.
        parts[i] = half * static_cast<double>(sum > 0 ? sum : 0);
    }
}

/// Adds up what a ray crosses.
template <int Channels>
struct GridIntegral {
    double sum[Channels] = {};

    bool uniform(const float* value, double begin, double end) {
        for (int c = 0; c < Channels; ++c) sum[c] += (end - begin) * double(value[c]);
        return true;
    }
    bool cells(const CellRun& run, const LatticeRay& ray, const RunSamples<Channels>& samples) {
        double parts[CellRun::kMost];
        for (int c = 0; c < Channels; ++c) {
            integrate(run, ray, samples.corner[c], parts);
            for (int i = 0; i < run.count; ++i) sum[c] += parts[i];
        }
        return true;
    }
};

/// The same until a channel exceeds its target.
template <int Channels>
struct GridSearch {
    int channel = 0;
    double target = 0;
    double sum[Channels] = {};
    std::optional<double> distance;

    bool uniform(const float* value, double begin, double end) {
        const double rest = target - sum[channel], rate = value[channel];
        if (rest < rate * (end - begin)) distance = end = std::min(begin + rest / rate, end);
        for (int c = 0; c < Channels; ++c) sum[c] += (end - begin) * double(value[c]);
        return !distance;
    }
    bool cells(const CellRun& run, const LatticeRay& ray, const RunSamples<Channels>& samples) {
        double parts[Channels][CellRun::kMost];
        for (int c = 0; c < Channels; ++c) integrate(run, ray, samples.corner[c], parts[c]);
        for (int i = 0; i < run.count; ++i) {
            const double rest = target - sum[channel];
            if (rest < parts[channel][i]) {
                const double begin = run.distance[i];
                distance = cellOf(run, ray, samples, channel, i).solve(begin, run.distance[i + 1], rest);
                for (int c = 0; c < Channels; ++c)
                    sum[c] += cellOf(run, ray, samples, c, i).integral(begin, *distance);
                return false;
            }
            for (int c = 0; c < Channels; ++c) sum[c] += parts[c][i];
        }
        return true;
    }
    static GridCell cellOf(const CellRun& run, const LatticeRay& ray, const RunSamples<Channels>& samples,
                           int channel, int i) {
        GridCell cell;
        for (int k = 0; k < kCorners; ++k) cell.corner[k] = samples.corner[channel][k][i];
        cell.origin = ray.origin - Vec3d(run.x[i], run.y[i], run.z[i]);
        cell.direction = ray.direction;
        return cell;
    }
};

}  // namespace metrolux::core
