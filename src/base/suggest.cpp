#include "base/suggest.h"

#include <algorithm>
#include <cctype>

namespace metrolux {

namespace {

/// "toWorld", "to_world" and "To_World" compare equal: a wrong spelling convention is the commonest slip.
std::string comparable(const std::string& name) {
    std::string result;
    for (const char c : name)
        if (c != '_' && c != '-') result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return result;
}

size_t editDistance(const std::string& a, const std::string& b) {
    std::vector<size_t> row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            const size_t substitution = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, substitution});
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

}  // namespace metrolux
