#include "base/suggest.h"

#include <algorithm>
#include <cctype>

namespace metrolux::core {

namespace {

/// "toWorld", "to_world" and "To_World" compare equal: a wrong spelling convention is the commonest slip.
std::string comparable(const std::string& name) {
    std::string result;
    for (const char c : name)
        if (c != '_' && c != '-') result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return result;
}

/// Insertions, deletions, substitutions and exchanges of neighbors (optimal string alignment).
size_t editDistance(const std::string& a, const std::string& b) {
    std::vector<size_t> beforeLast, last(b.size() + 1), row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        beforeLast = last;
        last = row;
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
            const bool exchanged = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (exchanged) row[j] = std::min(row[j], beforeLast[j - 2] + 1);
        }
    }
    return row[b.size()];
}

}  // namespace

std::string nearestName(const std::string& name, const std::vector<std::string>& candidates) {
    const std::string wanted = comparable(name);
    std::string best;
    size_t bestDistance = std::max<size_t>(1, (wanted.size() + 1) / 3) + 1;
    for (const std::string& candidate : candidates) {
        const std::string known = comparable(candidate);
        const size_t lengthDifference =
            std::max(known.size(), wanted.size()) - std::min(known.size(), wanted.size());
        if (lengthDifference >= bestDistance) continue;
        const size_t distance = editDistance(wanted, known);
        if (distance < bestDistance && distance < std::max(wanted.size(), known.size())) {
            bestDistance = distance;
            best = candidate;
        }
    }
    return best;
}

}  // namespace metrolux::core
