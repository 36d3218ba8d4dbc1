#include "io/pbrt/lexer.h"

#include "io/mesh_io.h"

#include <charconv>

namespace metrolux::core::pbrt {
namespace {

constexpr size_t kDeepestInclude = 64;

bool isSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
bool endsWord(char c) { return isSpace(c) || c == '"' || c == '[' || c == ']' || c == '#'; }

}  // namespace

void Lexer::include(const std::filesystem::path& file) {
    if (open_.size() >= kDeepestInclude)
        throw Error("{}: files include each other more than {} levels deep", file.string(), kDeepestInclude);
    MeshOptions options;
    options.memory = &memory_;
    texts_.push_back(readMeshFile(file, options));
    memory_.take(texts_.back().size(), "the scene");
    open_.push_back({&*names_.insert(file.string()).first, texts_.back()});
}

const Token& Lexer::peek() {
    if (!hasPeeked_) peeked_ = read();
    hasPeeked_ = true;
    return peeked_;
}

Token Lexer::next() {
    if (!hasPeeked_) return read();
    hasPeeked_ = false;
    return peeked_;
}

std::string Lexer::text(const Token& directive) {
    const Token token = next();
    if (token.kind != Token::Kind::String)
        throw token.error(
            fmt::format("found {}, expected a quoted text after {}", token.shown(), directive.shown()));
    return std::string(token.text);
}

void Lexer::readNumbers(const Token& directive, double* numbers, size_t count) {
    const bool isBracketed = peek().kind == Token::Kind::Open;
    if (isBracketed) next();
    for (size_t i = 0; i < count; ++i) {
        const Token token = next();
        if (token.kind != Token::Kind::Number)
            throw token.error(fmt::format("found {}, expected {} numbers after {}", token.shown(), count,
                                          directive.shown()));
        numbers[i] = token.number;
    }
    if (!isBracketed) return;
    if (const Token token = next(); token.kind != Token::Kind::Close)
        throw token.error(fmt::format("found {}, expected a \"]\" after {} numbers", token.shown(), count));
}

Token Lexer::read() {
    while (!open_.empty()) {
        File& file = open_.back();
        while (file.at < file.text.size()) {
            const char c = file.text[file.at];
            if (c == '#') {
                while (file.at < file.text.size() && file.text[file.at] != '\n') ++file.at;
            } else if (isSpace(c)) {
                file.line += c == '\n';
                ++file.at;
            } else {
                Token token;
                token.line = file.line;
                token.file = file.name;
                if (c == '"') return readString(file, token);
                if (c != '[' && c != ']') return readWord(file, token);
                token.kind = c == '[' ? Token::Kind::Open : Token::Kind::Close;
                token.text = file.text.substr(file.at++, 1);
                return token;
            }
        }
        last_ = file.name;
        lastLine_ = file.line;
        open_.pop_back();
    }
    Token end;
    end.file = last_;
    end.line = lastLine_;
    end.text = "the end of the file";
    return end;
}

Token Lexer::readString(File& file, Token token) {
    token.kind = Token::Kind::String;
    const size_t start = ++file.at;
    bool escaped = false;
    for (; file.at < file.text.size() && file.text[file.at] != '"'; ++file.at) {
        if (file.text[file.at] == '\n') break;
        if (file.text[file.at] == '\\') {
            escaped = true;
            ++file.at;
        }
    }
    if (file.at >= file.text.size() || file.text[file.at] != '"')
        throw token.error("found a string without an end on its line, expected '\"'");
    token.text = file.text.substr(start, file.at++ - start);
    if (!escaped) return token;
    std::string plain;
    for (size_t i = 0; i < token.text.size(); ++i) {
        char c = token.text[i];
        if (c == '\\' && i + 1 < token.text.size()) {
            c = token.text[++i];
            c = c == 'n' ? '\n' : c == 't' ? '\t' : c;
        }
        plain.push_back(c);
    }
    texts_.push_back(std::move(plain));
    token.text = texts_.back();
    return token;
}

Token Lexer::readWord(File& file, Token token) {
    size_t end = file.at;
    while (end < file.text.size() && !endsWord(file.text[end])) ++end;
    token.text = file.text.substr(file.at, end - file.at);
    file.at = end;
    token.kind = Token::Kind::Word;
    const char first = token.text[0];
    if (!(first == '-' || first == '+' || first == '.' || (first >= '0' && first <= '9'))) return token;
    token.kind = Token::Kind::Number;
    const char* const begin = token.text.data() + (first == '+' ? 1 : 0);
    const char* const stop = token.text.data() + token.text.size();
    const auto [rest, problem] = std::from_chars(begin, stop, token.number);
    if (problem != std::errc() || rest != stop || !std::isfinite(token.number))
        throw token.error(fmt::format("found \"{}\", expected a finite number", token.shown()));
    return token;
}

}  // namespace metrolux::core::pbrt
