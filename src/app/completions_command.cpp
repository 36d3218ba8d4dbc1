/// What shells and `man` know of the command, made from the descriptions of its options.

#include "app/commands.h"
#include "base/error.h"

#include <metrolux/version.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace metrolux::core::app {
namespace {

constexpr const char* kCompletionsExamples = R"(Examples:
  metrolux completions bash > ~/.local/share/bash-completion/completions/metrolux
  metrolux completions zsh > ~/.zfunc/_metrolux
  metrolux completions fish > ~/.config/fish/completions/metrolux.fish
  metrolux completions man | man -l -)";

std::vector<const CLI::App*> commandsOf(const CLI::App& root) {
    return root.get_subcommands([](const CLI::App* app) { return !app->get_group().empty(); });
}

/// Those that start with dashes and that help shows.
std::vector<const CLI::Option*> optionsOf(const CLI::App& app) {
    return app.get_options([](const CLI::Option* option) {
        return !option->get_group().empty() &&
               (!option->get_lnames().empty() || !option->get_snames().empty());
    });
}

std::vector<std::string> namesOf(const CLI::Option& option) {
    std::vector<std::string> names;
    for (const std::string& name : option.get_snames()) names.push_back(fmt::format("-{}", name));
    for (const std::string& name : option.get_lnames()) names.push_back(fmt::format("--{}", name));
    return names;
}

bool takesValue(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

/// On one line, with each of `special` after `escape`.
std::string escaped(const std::string& text, const std::string& special, const std::string& escape) {
    std::string result;
    for (const char c : text) {
        if (special.find(c) != std::string::npos) result += escape;
        result += c == '\n' ? ' ' : c;
    }
    return result;
}

void printBash(const CLI::App& root) {
    std::vector<std::string> commands;
    for (const CLI::App* command : commandsOf(root)) commands.push_back(command->get_name());
    fmt::print(
        "_metrolux() {{\n  local word=${{COMP_WORDS[COMP_CWORD]}} options=\n  if ((COMP_CWORD == 1)); then\n"
        "    options='{} --help --version'\n  else\n    case ${{COMP_WORDS[1]}} in\n",
        fmt::join(commands, " "));
    for (const CLI::App* command : commandsOf(root)) {
        std::vector<std::string> names;
        for (const CLI::Option* option : optionsOf(*command))
            for (const std::string& name : namesOf(*option)) names.push_back(name);
        fmt::print("      {}) options='{}' ;;\n", command->get_name(), fmt::join(names, " "));
    }
    fmt::print(
        "    esac\n    [[ $word == -* ]] || options=\n  fi\n"
        "  COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n}}\n"
        "complete -o default -F _metrolux metrolux\n");
}

void printZsh(const CLI::App& root) {
    fmt::print("#compdef metrolux\n\n_metrolux() {{\n  local -a commands=(\n");
    for (const CLI::App* command : commandsOf(root))
        fmt::print("    '{}:{}'\n", command->get_name(), escaped(command->get_description(), "'", "'\\'"));
    fmt::print(
        "  )\n  if ((CURRENT == 2)); then\n    _describe command commands\n"
        "    _arguments '--help[Print help]' '--version[Show the version]'\n    return\n  fi\n"
        "  local command=$words[2]\n  shift words\n  ((CURRENT--))\n  case $command in\n");
    for (const CLI::App* command : commandsOf(root)) {
        fmt::print("    {})\n      _arguments -s \\\n", command->get_name());
        for (const CLI::Option* option : optionsOf(*command))
            for (const std::string& name : namesOf(*option)) {
                std::string help = escaped(option->get_description(), "[]:\\", "\\");
                help = escaped(help, "'", "'\\'");
                fmt::print("        '*{}{}[{}]{}' \\\n", name,
                           !takesValue(*option)     ? ""
                           : name.starts_with("--") ? "="
                                                    : "+",
                           help, takesValue(*option) ? ":value:_files" : "");
            }
        fmt::print("        '*:file:_files'\n      ;;\n");
    }
    fmt::print("  esac\n}}\n\n_metrolux \"$@\"\n");
}

void printFish(const CLI::App& root) {
    for (const CLI::App* command : commandsOf(root))
        fmt::print("complete -c metrolux -n __fish_use_subcommand -f -a {} -d '{}'\n", command->get_name(),
                   escaped(command->get_description(), "'\\", "\\"));
    fmt::print(
        "complete -c metrolux -n __fish_use_subcommand -f -l help -d 'Print help'\n"
        "complete -c metrolux -n __fish_use_subcommand -f -l version -d 'Show the version'\n");
    for (const CLI::App* command : commandsOf(root))
        for (const CLI::Option* option : optionsOf(*command)) {
            std::string names;
            for (const std::string& name : option->get_snames()) names += fmt::format(" -s {}", name);
            for (const std::string& name : option->get_lnames()) names += fmt::format(" -l {}", name);
            fmt::print("complete -c metrolux -n '__fish_seen_subcommand_from {}'{}{} -d '{}'\n",
                       command->get_name(), names, takesValue(*option) ? " -r" : "",
                       escaped(option->get_description(), "'\\", "\\"));
        }
}

/// Text for roff: a line may not start with a dot or a quote.
std::string roff(const std::string& text) {
    const bool isRequest = !text.empty() && (text[0] == '.' || text[0] == '\'');
    return fmt::format("{}{}", isRequest ? "\\&" : "", escaped(text, "\\-", "\\"));
}
/// Several lines as they are.
void printExamples(const std::string& text) {
    fmt::print(".nf\n");
    size_t start = 0;
    while (start <= text.size()) {
        const size_t end = std::min(text.find('\n', start), text.size());
        fmt::print("{}\n", roff(text.substr(start, end - start)));
        start = end + 1;
    }
    fmt::print(".fi\n");
}

void printManual(const CLI::App& root) {
    fmt::print(
        ".TH METROLUX 1 \"\" \"metrolux {}\" \"User Commands\"\n.SH NAME\nmetrolux \\- physically based "
        "renderer\n"
        ".SH SYNOPSIS\n.B metrolux\nCOMMAND [OPTION]...\n.SH DESCRIPTION\n{}\n",
        metrolux::version(), roff(root.get_description()));
    printExamples(root.get_footer());
    for (const CLI::App* command : commandsOf(root)) {
        fmt::print(".SH metrolux {}\n{}.\n", command->get_name(), roff(command->get_description()));
        for (const CLI::Option* option : command->get_options())
            if (option->get_positional() && !option->get_group().empty() && option->nonpositional() == false)
                fmt::print(".TP\n.I {}\n{}\n", roff(option->get_name()), roff(option->get_description()));
        for (const CLI::Option* option : optionsOf(*command))
            fmt::print(".TP\n.B {}{}\n{}\n", roff(fmt::format("{}", fmt::join(namesOf(*option), ", "))),
                       takesValue(*option) ? fmt::format(" {}", roff(option->get_option_text())) : "",
                       roff(option->get_description()));
        if (!command->get_footer().empty()) printExamples(command->get_footer());
    }
}

}  // namespace

Run addCompletionsCommand(CLI::App& parent) {
    CLI::App* app = parent.add_subcommand("completions", "Print completions for a shell, or the manual page");
    app->footer(kCompletionsExamples);
    auto kind = std::make_shared<std::string>();
    app->add_option("kind", *kind, "bash, zsh, fish or man")->required();
    return [kind, root = &parent] {
        if (*kind == "bash")
            printBash(*root);
        else if (*kind == "zsh")
            printZsh(*root);
        else if (*kind == "fish")
            printFish(*root);
        else if (*kind == "man")
            printManual(*root);
        else
            throw Error("unknown shell '{}', expected bash, zsh, fish or man", *kind);
        return kDone;
    };
}

}  // namespace metrolux::core::app
