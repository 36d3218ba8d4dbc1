#include "view/command_text.h"

#include "base/error.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace metrolux::core::view {
namespace {

double number(const nlohmann::json& json, const char* name, double otherwise, double least, double most) {
    const auto found = json.find(name);
    if (found == json.end()) return otherwise;
    const double value = found->is_number() ? found->get<double>() : NAN;
    if (!(value >= least && value <= most))
        throw Error("{}: found {}, expected a number from {} to {}", name, found->dump(), least, most);
    return value;
}

int wholeNumber(const nlohmann::json& json, const char* name) {
    constexpr double kMost = 1 << 24;
    if (!json.contains(name)) throw Error("{}: found nothing, expected a whole number", name);
    const double value = number(json, name, NAN, 0, kMost);
    if (value != std::floor(value)) throw Error("{}: expected a whole number", name);
    return static_cast<int>(value);
}

CameraMotion motionOf(const nlohmann::json& json) {
    constexpr double kTurn = 7, kFar = 1e4;
    CameraMotion motion;
    motion.begins = json.value("begins", false);
    motion.yaw = number(json, "yaw", 0, -kTurn, kTurn);
    motion.pitch = number(json, "pitch", 0, -kTurn, kTurn);
    motion.dolly = number(json, "dolly", 1, 1 / kFar, kFar);
    motion.right = number(json, "right", 0, -kFar, kFar);
    motion.up = number(json, "up", 0, -kFar, kFar);
    return motion;
}

/// An integrator's name; "" where none may be meant.
std::string integratorOf(const nlohmann::json& json, bool noneAllowed) {
    const std::string name = json.value("integrator", "");
    if (name.empty() && noneAllowed) return name;
    const std::vector<metrolux::IntegratorDescription> all = metrolux::integrators();
    if (std::none_of(all.begin(), all.end(), [&](const auto& i) { return i.name == name; }))
        throw Error("there is no integrator '{}'", name);
    return name;
}

}  // namespace

Command commandFromText(std::string_view text) {
    using Kind = Command::Kind;
    const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
    if (!json.is_object()) throw Error("expected a JSON object with the name of a command in \"do\"");
    try {
        const std::string name = json.value("do", "");
        Command command;
        if (name == "pause") {
            command.kind = Kind::Pause;
        } else if (name == "resume") {
            command.kind = Kind::Resume;
        } else if (name == "stop") {
            command.kind = Kind::Stop;
        } else if (name == "save") {
            command.kind = Kind::Save;
        } else if (name == "move") {
            command.kind = Kind::Move;
            command.motion = motionOf(json);
        } else if (name == "reset_camera") {
            command.kind = Kind::ResetCamera;
        } else if (name == "crop") {
            command.kind = Kind::Crop;
            if (json.contains("width"))
                command.crop = Crop{wholeNumber(json, "x"), wholeNumber(json, "y"),
                                    wholeNumber(json, "width"), wholeNumber(json, "height")};
        } else if (name == "integrator") {
            command.kind = Kind::Integrator;
            command.integrator = integratorOf(json, false);
        } else if (name == "compare") {
            command.kind = Kind::Compare;
            command.integrator = integratorOf(json, true);
        } else {
            throw Error(
                "found the command '{}', expected pause, resume, stop, save, move, reset_camera, crop, "
                "integrator or compare",
                name);
        }
        return command;
    } catch (const nlohmann::json::exception& problem) {
        throw Error("a value is not of the expected type: {}", problem.what());
    }
}

}  // namespace metrolux::core::view
