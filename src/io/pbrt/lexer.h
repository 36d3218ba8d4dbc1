#pragma once
/// The words of a pbrt scene, across the files that it includes.

#include "base/error.h"
#include "base/memory_budget.h"
#include "io/mitsuba/properties.h"

#include <array>
#include <deque>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace metrolux::core::pbrt {

using mitsuba::Location;

struct Token {
    enum class Kind { Word, String, Number, Open, Close, End };
    Kind kind = Kind::End;
    std::string_view text;  ///< as written, strings without quotes; valid as long as the lexer
    double number = 0;
    int line = 0;
    const std::string* file = nullptr;

    Location where() const { return {*file, line, ""}; }
    Error error(const std::string& message) const { return Error("{}: {}", where().str(), message); }
    /// Its beginning, for messages.
    std::string shown() const { return std::string(text.substr(0, 40)); }
    /// Runs an action whose errors do not know their place.
    template <class Action>
    auto located(const Action& action) const {
        try {
            return action();
        } catch (const Error& problem) {
            const std::string message = problem.what();
            if (message.starts_with(*file + ":")) throw;
            throw error(fmt::format("{}: {}", shown(), message));
        }
    }
};

class Lexer {
  public:
    /// Throws Error for a file that cannot be read.
    Lexer(const std::filesystem::path& file, MemoryBudget& memory) : memory_(memory) { include(file); }

    /// Throws Error for what is no word of the format.
    Token next();
    const Token& peek();
    // What has to follow a directive. Throw Error for anything else.

    /// In quotes.
    std::string text(const Token& directive);
    /// With or without brackets around them.
    template <size_t N>
    std::array<double, N> numbers(const Token& directive) {
        std::array<double, N> result;
        readNumbers(directive, result.data(), N);
        return result;
    }
    /// What follows comes from this file, then what came next. Nothing may have been peeked at.
    void include(const std::filesystem::path& file);
    /// How many files are open within each other.
    size_t depth() const { return open_.size(); }
    const std::set<std::string>& files() const { return names_; }

  private:
    struct File {
        const std::string* name;
        std::string_view text;
        size_t at = 0;
        int line = 1;
    };
    Token read();
    void readNumbers(const Token& directive, double* numbers, size_t count);
    Token readString(File& file, Token token);
    Token readWord(File& file, Token token);

    MemoryBudget& memory_;
    std::deque<std::string> texts_;  ///< of all files, and of strings with escapes
    std::set<std::string> names_;
    std::vector<File> open_;
    const std::string* last_ = nullptr;  ///< file that ended last
    int lastLine_ = 0;
    Token peeked_;
    bool hasPeeked_ = false;
};

}  // namespace metrolux::core::pbrt
