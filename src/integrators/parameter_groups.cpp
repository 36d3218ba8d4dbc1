#include "integrators/parameter_groups.h"

#include <algorithm>
#include <sstream>

namespace metrolux::core {

std::string SplitForm::expected() const {
    return fmt::format("{}three numbers above 0, such as 1/1/2", mayBeMeasured ? "`auto` or " : "");
}

void SplitForm::read(const ParameterValue& value, ReplicaSplit& to) const {
    const std::string text = toText(value);
    to = {};
    to.measured = mayBeMeasured && text == "auto";
    if (to.measured) return;
    std::istringstream in(text);
    in.imbue(std::locale::classic());
    char slash1 = 0, slash2 = 0;
    in >> to.parts[0] >> slash1 >> to.parts[1] >> slash2 >> to.parts[2];
    const bool positive =
        std::all_of(to.parts.begin(), to.parts.end(), [](double p) { return p > 0 && p <= 1e6; });
    if (!in || slash1 != '/' || slash2 != '/' || in.peek() != EOF || !positive)
        throw Error("found '{}', expected {}", text, expected());
}

ParameterValue SplitForm::write(const ReplicaSplit& split) const {
    if (split.measured) return std::string("auto");
    return fmt::format("{}/{}/{}", split.parts[0], split.parts[1], split.parts[2]);
}

void SplitForm::describe(ParameterInfo& info) const {
    info.expected = expected();
    info.placeholder = mayBeMeasured ? "U/V/F|auto" : "U/V/F";
}

}  // namespace metrolux::core
