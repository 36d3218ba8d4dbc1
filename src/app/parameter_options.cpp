#include "app/parameter_options.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>

namespace metrolux::core::app {
namespace {

/// A parameter with the integrators that have it, in the order of the list. They may differ in its default,
/// and in which letters there are.
struct Shared {
    std::vector<const ParameterInfo*> infos;
    std::vector<std::string> integrators;
    const ParameterInfo& first() const { return *infos.front(); }
};

/// In the order in which the integrators name them.
std::vector<Shared> sharedParameters() {
    std::vector<Shared> result;
    for (const IntegratorDescription& integrator : integratorList()) {
        for (const ParameterInfo& info : integrator.parameters) {
            auto found = std::find_if(result.begin(), result.end(),
                                      [&](const Shared& s) { return s.first().name == info.name; });
            if (found == result.end()) found = result.insert(found, Shared{});
            found->infos.push_back(&info);
            found->integrators.push_back(integrator.name);
        }
    }
    return result;
}

/// "default: kelemen; vpt, split_mcmc: adaptive".
std::string defaultsOf(const Shared& parameter) {
    std::vector<std::pair<std::string, std::vector<std::string>>> byText;
    for (size_t i = 0; i < parameter.infos.size(); ++i) {
        const std::string text = parameter.infos[i]->defaultText();
        auto found =
            std::find_if(byText.begin(), byText.end(), [&](const auto& e) { return e.first == text; });
        if (found == byText.end()) found = byText.insert(found, {text, {}});
        found->second.push_back(parameter.integrators[i]);
    }
    std::stable_sort(byText.begin(), byText.end(),
                     [](const auto& a, const auto& b) { return a.second.size() > b.second.size(); });
    std::string result = "default: " + byText.front().first;
    for (size_t i = 1; i < byText.size(); ++i)
        result += fmt::format("; {}: {}", fmt::join(byText[i].second, ", "), byText[i].first);
    return result;
}

/// What it is, its defaults, and who has it.
std::string helpOf(const Shared& parameter) {
    const ParameterInfo& info = parameter.first();
    std::string help = info.help;
    help[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(help[0])));
    if (info.type == ParameterType::Boolean && info.defaultValue == ParameterValue(true))
        help = fmt::format("Do not {}", info.help);
    else
        help += fmt::format("\n({})", defaultsOf(parameter));
    return fmt::format("{}\nfor {}", help, fmt::join(parameter.integrators, ", "));
}

/// The value as one of the integrators takes it. Its message is that of the first.
std::string problemWith(const Shared& parameter, const std::string& text) {
    std::string problem;
    for (const ParameterInfo* info : parameter.infos) {
        try {
            info->checked(text);
            return {};
        } catch (const Error& error) {
            if (problem.empty()) problem = error.what();
        }
    }
    return problem;
}

std::string dashed(std::string name) {
    std::replace(name.begin(), name.end(), '_', '-');
    return name;
}

}  // namespace

std::string optionOf(const ParameterInfo& parameter) {
    const bool on = parameter.defaultValue == ParameterValue(true);
    return fmt::format("--{}{}", on ? "no-" : "", dashed(parameter.name));
}

std::vector<const ParameterInfo*> allParameters() {
    std::vector<const ParameterInfo*> result;
    for (const Shared& parameter : sharedParameters()) result.push_back(&parameter.first());
    return result;
}

void addParameterOptions(CLI::App& app, ParameterValues& given) {
    const char* const group = "Parameters of integrators (`metrolux integrators NAME` lists those of one)";
    for (const Shared& parameter : sharedParameters()) {
        const ParameterInfo& info = parameter.first();
        if (info.type == ParameterType::Boolean) {
            const bool other = info.defaultValue == ParameterValue(false);
            app.add_flag_function(
                   optionOf(info), [&given, name = info.name, other](int64_t) { given[name] = other; },
                   helpOf(parameter))
                ->group(group);
            continue;
        }
        const auto add = [&](const std::string& option) {
            return app
                .add_option_function<std::string>(
                    option, [&given, name = info.name](const std::string& text) { given[name] = text; },
                    helpOf(parameter))
                ->option_text(info.placeholder)
                ->check(CLI::Validator(
                    [parameter](const std::string& text) { return problemWith(parameter, text); }, ""));
        };
        add(optionOf(info))->group(group);
        if (!info.alias.empty()) add("--" + dashed(info.alias))->group("");  // works, but is not shown
    }
}

void settleParameters(ParameterValues& given, const IntegratorDescription& integrator) {
    ParameterSet set(integrator.parameters);
    for (const Shared& parameter : sharedParameters()) {
        const std::string& name = parameter.first().name;
        const auto found = given.find(name);
        if (found == given.end()) continue;
        const std::string option = optionOf(parameter.first());
        if (set.find(name)) {
            set.set(name, found->second, option);
            continue;
        }
        spdlog::warn("{} has no effect on {}: it is for {}", option, integrator.name,
                     fmt::join(parameter.integrators, ", "));
        given.erase(found);
    }
}

}  // namespace metrolux::core::app
