#include "image/padded_plane.h"

#include "base/parallel.h"

#include <algorithm>

namespace metrolux::core {

void PaddedPlane::extend() {
    for (int y = -kMargin; y < height_ + kMargin; ++y) {
        const int inside = std::clamp(y, 0, height_ - 1);
        float* row = at(0, y);
        if (inside != y) std::copy_n(at(0, inside), width_, row);
        std::fill_n(row - kMargin, kMargin, row[0]);
        std::fill_n(row + width_, kMargin, row[width_ - 1]);
    }
}

ColorPlanes makeColorPlanes(int width, int height) {
    return {PaddedPlane(width, height), PaddedPlane(width, height), PaddedPlane(width, height)};
}

PaddedPlane boxMeans(const PaddedPlane& plane, int radius) {
    const int width = plane.width(), height = plane.height();
    PaddedPlane rows(width, height), result(width, height);
    parallelFor(static_cast<size_t>(height), [&](size_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < width; ++x) {
            const int first = std::max(0, x - radius), last = std::min(width - 1, x + radius);
            float sum = 0;
            for (int i = first; i <= last; ++i) sum += *plane.at(i, y);
            *rows.at(x, y) = sum / static_cast<float>(last - first + 1);
        }
    });
    parallelFor(static_cast<size_t>(height), [&](size_t row) {
        const int y = static_cast<int>(row);
        const int first = std::max(0, y - radius), last = std::min(height - 1, y + radius);
        for (int x = 0; x < width; ++x) {
            float sum = 0;
            for (int i = first; i <= last; ++i) sum += *rows.at(x, i);
            *result.at(x, y) = sum / static_cast<float>(last - first + 1);
        }
    });
    result.extend();
    return result;
}

}  // namespace metrolux::core
