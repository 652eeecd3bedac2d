// Every file of the corpus, through its target: what was once found stays away.
#include <gtest/gtest.h>

#include "core/mapped_file.h"
#include "pointbake/error.h"
#include "targets.h"

namespace pointbake::fuzz {
namespace {

namespace fs = std::filesystem;

class Corpus : public testing::TestWithParam<Target> {};

TEST_P(Corpus, IsReadOrRefused) {
    std::size_t num_files = 0;
    for (const auto& entry : fs::directory_iterator(fs::path(POINTBAKE_CORPUS) / GetParam().name)) {
        SCOPED_TRACE(entry.path());
        const MappedFile file(entry.path());
        try {
            GetParam().run(file.bytes());
        } catch (const Error&) {
        }
        ++num_files;
    }
    EXPECT_GT(num_files, 0U);
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus, testing::ValuesIn(targets().begin(), targets().end()),
                         [](const auto& corpus) { return std::string(corpus.param.name); });

}  // namespace
}  // namespace pointbake::fuzz
