/// What libFuzzer does, in small: for compilers without it. Runs a corpus, then random mutations of it for
/// some seconds; without feedback, but the same seed gives the same inputs. An input that ends the process
/// stays in the file that --artifact names.

#include "base/rng.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

namespace fs = std::filesystem;
using metrolux::core::CounterRng;

constexpr size_t kLargestInput = 64 << 10;

struct Options {
    double seconds = 0;
    uint64_t seed = 0;
    fs::path artifact = "crash-input";
    std::vector<fs::path> inputs;  ///< files, or folders of them
};

Options parseOptions(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        const bool hasValue = i + 1 < argc;
        if (word == "--seconds" && hasValue)
            options.seconds = std::stod(argv[++i]);
        else if (word == "--seed" && hasValue)
            options.seed = std::stoull(argv[++i]);
        else if (word == "--artifact" && hasValue)
            options.artifact = argv[++i];
        else if (word.starts_with("-"))
            throw std::runtime_error("unknown option " + word);
        else
            options.inputs.emplace_back(word);
    }
    return options;
}

std::string readFile(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw std::runtime_error("cannot read " + file.string());
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// In the order of their names, so that a seed means the same everywhere.
std::vector<std::string> readCorpus(const std::vector<fs::path>& inputs) {
    std::vector<fs::path> files;
    for (const fs::path& input : inputs) {
        if (!fs::is_directory(input)) {
            files.push_back(input);
            continue;
        }
        for (const auto& entry : fs::recursive_directory_iterator(input))
            if (entry.is_regular_file()) files.push_back(entry.path());
    }
    if (files.empty()) throw std::runtime_error("the corpus is empty");
    std::sort(files.begin(), files.end());
    std::vector<std::string> corpus;
    for (const fs::path& file : files) corpus.push_back(readFile(file));
    return corpus;
}

class Mutator {
  public:
    Mutator(const std::vector<std::string>& corpus, uint64_t seed) : corpus_(corpus), rng_(seed) {}

    std::string next() {
        std::string input = corpus_[below(corpus_.size())];
        for (size_t steps = 1 + below(8); steps > 0; --steps) mutate(input);
        input.resize(std::min(input.size(), kLargestInput));
        return input;
    }

  private:
    size_t below(size_t n) { return static_cast<size_t>(rng_.next1D() * static_cast<float>(n)) % n; }
    char randomByte() { return static_cast<char>(below(256)); }

    void mutate(std::string& input) {
        if (input.empty()) input += randomByte();
        const size_t at = below(input.size());
        switch (below(7)) {
            case 0:
                input[at] = static_cast<char>(input[at] ^ (1 << below(8)));
                break;
            case 1:
                input[at] = randomByte();
                break;
            case 2:
                input.insert(at, 1 + below(4), randomByte());
                break;
            case 3:
                input.erase(at, 1 + below(16));
                break;
            case 4:
                input.insert(at, extreme());
                break;
            case 5:
                input.insert(at, piece(input));
                break;
            default:
                input.insert(at, piece(corpus_[below(corpus_.size())]));
        }
    }

    std::string piece(const std::string& text) {
        if (text.empty()) return {};
        const size_t begin = below(text.size());
        return text.substr(begin, 1 + below(64));
    }

    /// Numbers at the limits, as text and as bytes.
    std::string extreme() {
        static const std::vector<std::string> kValues = {"0",
                                                         "-1",
                                                         "1e30",
                                                         "1e-30",
                                                         "nan",
                                                         "4294967295",
                                                         "18446744073709551615",
                                                         "-2147483648",
                                                         "1e999",
                                                         "inf",
                                                         std::string(4, '\xff'),
                                                         std::string(8, '\0'),
                                                         std::string(7, '\xff') + '\x7f'};
        return kValues[below(kValues.size())];
    }

    const std::vector<std::string>& corpus_;
    CounterRng rng_;
};

class Runner {
  public:
    explicit Runner(fs::path artifact) : artifact_(std::move(artifact)) {}
    ~Runner() {
        std::error_code code;
        fs::remove(artifact_, code);
    }
    void run(const std::string& input) {
        std::ofstream(artifact_, std::ios::binary) << input;
        LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(input.data()), input.size());
        ++count_;
    }
    size_t count() const { return count_; }

  private:
    fs::path artifact_;
    size_t count_ = 0;
};

double secondsNow() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

int main(int argc, char** argv) {
    const Options options = parseOptions(argc, argv);
    const std::vector<std::string> corpus = readCorpus(options.inputs);
    Runner runner(options.artifact);
    runner.run({});
    for (const std::string& input : corpus) runner.run(input);
    Mutator mutator(corpus, options.seed);
    const double end = secondsNow() + options.seconds;
    while (secondsNow() < end) runner.run(mutator.next());
    fmt::print("{} inputs, {} of them of the corpus\n", runner.count(), corpus.size());
    return 0;
}
