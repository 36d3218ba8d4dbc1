#pragma once
#include "base/memory_budget.h"
#include "endpoint/goniometric_light.h"

#include <filesystem>
#include <string>
#include <vector>

namespace metrolux::core {

/// A photometric web of IES LM-63 (1986 to 2019) of type C, in candela, its multipliers applied. The tilt of
/// a lamp is not, with a warning. Throws Error that names the line, what was found and what was expected.
PhotometricWeb readIes(const std::filesystem::path& file, std::vector<std::string>& warnings,
                       MemoryBudget* memory = nullptr);

}  // namespace metrolux::core
