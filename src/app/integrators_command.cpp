#include "app/commands.h"
#include "app/parameter_options.h"

#include <nlohmann/json.hpp>

namespace metrolux::core::app {
namespace {

constexpr const char* kIntegratorsExamples = R"(Examples:
  metrolux integrators                                 # names, one a line, with what each is
  metrolux integrators mcmc_vcm                        # its parameters
  metrolux integrators --markdown                      # all of it: docs/reference/parameters.md
  metrolux integrators --json                          # all of it, for programs

A parameter is an option of `metrolux render` (--chain-inefficiency 8), follows an integrator of `metrolux study`
(mcmc_vcm:chain-inefficiency=8), and stands in a scene's <integrator> (<float name="chain_inefficiency" value="8"/>).)";

struct IntegratorsArguments {
    std::string name;
    bool markdown = false, json = false;
};

/// What a scene may call the integrator besides its name.
std::string otherTypes(const IntegratorDescription& integrator) {
    return integrator.mitsubaTypes.empty()
               ? ""
               : fmt::format("In scenes also: {}.", fmt::join(integrator.mitsubaTypes, ", "));
}

std::string usage(const ParameterInfo& info) {
    return info.type == ParameterType::Boolean ? optionOf(info)
                                               : fmt::format("{} {}", optionOf(info), info.placeholder);
}

void printOne(const IntegratorDescription& integrator) {
    fmt::print("{}: {}\n", integrator.name, integrator.summary);
    if (!integrator.mitsubaTypes.empty()) fmt::print("{}\n", otherTypes(integrator));
    for (const ParameterInfo& info : integrator.parameters) {
        fmt::print("\n  {}\n      {}\n      in scenes: {}{}; expected: {}; default: {}\n", usage(info),
                   info.help, info.name, info.alias.empty() ? "" : fmt::format(" or {}", info.alias),
                   info.expected, info.defaultText());
    }
}

/// Bars end the cells of a table.
std::string cell(std::string text) {
    for (size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, 1, '\\');
    return text;
}

void printMarkdown() {
    fmt::print(
        "# Parameters of the integrators\n\n"
        "Made by `metrolux integrators --markdown` from what each integrator says of itself; a test "
        "compares.\n"
        "What the integrators are: [integrators.md](integrators.md).\n\n"
        "In a scene's `<integrator>` a parameter has the name of the first column. As an option of `metrolux "
        "render` it is\n`--chain-inefficiency 8`, after an integrator of `metrolux study` "
        "`mcmc_vcm:chain-inefficiency=8`. A flag that is on\nis turned off by `--no-correlation-aware`.\n");
    for (const IntegratorDescription& integrator : integratorList()) {
        fmt::print("\n## {}\n\n{}{}.\n", integrator.name,
                   static_cast<char>(std::toupper(static_cast<unsigned char>(integrator.summary[0]))),
                   integrator.summary.substr(1));
        if (!integrator.mitsubaTypes.empty()) fmt::print("{}\n", otherTypes(integrator));
        if (integrator.parameters.empty()) {
            fmt::print("\nIt has no parameters of its own.\n");
            continue;
        }
        fmt::print("\n| parameter | default | expected |\n|---|---|---|\n");
        for (const ParameterInfo& info : integrator.parameters)
            fmt::print("| {} | {} | {} |\n", info.name, cell(info.defaultText()), cell(info.expected));
    }
    fmt::print("\n## What the parameters are\n\n");
    for (const ParameterInfo* info : allParameters())
        fmt::print("- `{}`{}: {}.\n", info->name,
                   info->alias.empty() ? "" : fmt::format(" (also `{}`)", info->alias), info->help);
}

void printJson() {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const IntegratorDescription& integrator : integratorList()) {
        nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
        for (const ParameterInfo& info : integrator.parameters)
            parameters.push_back({{"name", info.name},
                                  {"help", info.help},
                                  {"default", info.defaultText()},
                                  {"expected", info.expected}});
        all.push_back(
            {{"name", integrator.name}, {"summary", integrator.summary}, {"parameters", parameters}});
    }
    fmt::print("{}\n", all.dump(1));
}

int listIntegrators(const IntegratorsArguments& a) {
    if (a.markdown) {
        printMarkdown();
    } else if (a.json) {
        printJson();
    } else if (!a.name.empty()) {
        printOne(findIntegrator(a.name));
    } else {
        for (const IntegratorDescription& integrator : integratorList())
            fmt::print("{:14} {}\n", integrator.name, integrator.summary);
    }
    return kDone;
}

}  // namespace

Run addIntegratorsCommand(CLI::App& parent) {
    CLI::App* app = parent.add_subcommand("integrators", "List the integrators and their parameters");
    app->footer(kIntegratorsExamples);
    auto a = std::make_shared<IntegratorsArguments>();
    app->add_option("name", a->name, "An integrator, for its parameters");
    app->add_flag("--markdown", a->markdown, "All integrators and parameters as a page of the documentation");
    app->add_flag("--json", a->json, "All integrators and parameters as JSON, for programs")
        ->excludes("--markdown");
    return [a] { return listIntegrators(*a); };
}

}  // namespace metrolux::core::app
