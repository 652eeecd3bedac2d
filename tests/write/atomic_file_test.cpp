#include "core/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>

#include "write/write_fixtures.h"

namespace pointbake {
namespace {

using fixtures::error_of;
using fixtures::Folder;
using fixtures::read_text;
using fixtures::write_text;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string kLong(std::size_t{3} << 20, 'x');  // several buffers

/// No file may grow beyond some bytes: what a full disk looks like, but for the error's name.
class FileSizeLimit {
 public:
    explicit FileSizeLimit(rlim_t bytes) {
        old_handler_ = std::signal(SIGXFSZ, SIG_IGN);
        ::getrlimit(RLIMIT_FSIZE, &old_);
        const rlimit limit{bytes, old_.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FileSizeLimit() {
        ::setrlimit(RLIMIT_FSIZE, &old_);
        std::signal(SIGXFSZ, old_handler_);
    }

 private:
    rlimit old_{};
    void (*old_handler_)(int) = nullptr;
};

TEST(AtomicFile, HoldsWhatWasWrittenInAnySizes) {
    const Folder folder;
    AtomicFile file(folder / "a.bin");
    std::string expected;
    for (std::size_t n : {0U, 1U, 1000U, 1048575U, 1048576U, 1048577U, 3U}) {
        const std::string piece(n, static_cast<char>('a' + n % 26));
        file.write(piece);
        expected += piece;
    }
    file.write_value(std::uint32_t{0x64636261});
    expected += "abcd";
    EXPECT_EQ(file.size(), expected.size());
    file.commit();
    EXPECT_EQ(read_text(folder / "a.bin"), expected);
    EXPECT_THAT(folder.names(), ElementsAre("a.bin"));
}

TEST(AtomicFile, TargetStaysAsItWasUntilCommit) {
    const Folder folder;
    write_text(folder / "a", "old");
    {
        AtomicFile file(folder / "a");
        file.write(kLong);
        EXPECT_EQ(read_text(folder / "a"), "old");
    }
    EXPECT_EQ(read_text(folder / "a"), "old");
    EXPECT_THAT(folder.names(), ElementsAre("a"));
    AtomicFile file(folder / "a");
    file.write("new");
    file.commit();
    EXPECT_EQ(read_text(folder / "a"), "new");
}

TEST(AtomicFile, TwoFilesOfOneFolderDoNotMeet) {
    const Folder folder;
    AtomicFile a(folder / "a"), b(folder / "b");
    a.write("1");
    b.write("2");
    a.commit();
    b.commit();
    EXPECT_EQ(read_text(folder / "a") + read_text(folder / "b"), "12");
}

TEST(AtomicFile, FollowsALinkInsteadOfReplacingIt) {
    const Folder folder;
    write_text(folder / "real", "old");
    std::filesystem::create_symlink("real", folder / "link");
    AtomicFile file(folder / "link");
    file.write("new");
    file.commit();
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
    EXPECT_EQ(read_text(folder / "real"), "new");
}

TEST(AtomicFile, APrivateFileStaysPrivate) {
    const Folder folder;
    write_text(folder / "a", "old");
    const auto mode = std::filesystem::perms::owner_read | std::filesystem::perms::owner_write;
    std::filesystem::permissions(folder / "a", mode);
    AtomicFile file(folder / "a");
    file.commit();
    EXPECT_EQ(std::filesystem::status(folder / "a").permissions(), mode);
}

TEST(AtomicFile, TellsOfAFullDiskAndLeavesNothing) {
    const Folder folder;
    const FileSizeLimit limit(std::size_t{1} << 20);
    const auto thrown = error_of([&] {
        AtomicFile file(folder / "big.glb");
        file.write(kLong);
        file.commit();
    });
    ASSERT_TRUE(thrown);
    EXPECT_EQ(thrown->code, ErrorCode::kOutput);
    EXPECT_THAT(thrown->message, HasSubstr("big.glb"));
    EXPECT_THAT(thrown->message, HasSubstr("free some space"));
    EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(AtomicFile, WritesADeviceDirectlyAndTellsThatItIsFull) {
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
    const auto thrown = error_of([] {
        AtomicFile file("/dev/full");
        file.write("some");
        file.commit();
    });
    ASSERT_TRUE(thrown);
    EXPECT_EQ(thrown->code, ErrorCode::kOutput);
    EXPECT_THAT(thrown->message, HasSubstr("No space left"));
    EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST(AtomicFile, RefusesAFolderAsTarget) {
    const Folder folder;
    std::filesystem::create_directory(folder / "sub");
    for (const auto& target : {folder / "sub", folder / "sub/", folder.path()}) {
        const auto thrown = error_of([&] { AtomicFile file(target); });
        ASSERT_TRUE(thrown) << target;
        EXPECT_EQ(thrown->code, ErrorCode::kOutput);
        EXPECT_THAT(thrown->message, HasSubstr("give a file name"));
    }
}

TEST(AtomicFile, NamesTheMissingFolder) {
    const Folder folder;
    const auto thrown = error_of([&] { AtomicFile file(folder / "no/such/a.glb"); });
    ASSERT_TRUE(thrown);
    EXPECT_EQ(thrown->code, ErrorCode::kOutput);
    EXPECT_THAT(thrown->message, HasSubstr("no/such' does not exist: create it"));
    write_text(folder / "file", "");
    const auto other = error_of([&] { AtomicFile file(folder / "file/a.glb"); });
    ASSERT_TRUE(other);
    EXPECT_EQ(other->code, ErrorCode::kOutput);
    EXPECT_THAT(other->message, HasSubstr("is not a folder"));
}

TEST(AtomicFile, TellsThatAFolderCannotBeWritten) {
    if (!std::filesystem::exists("/sys/kernel")) GTEST_SKIP() << "/sys is not mounted";
    // Not even root creates files there.
    const auto thrown = error_of([] { AtomicFile file("/sys/a.glb"); });
    ASSERT_TRUE(thrown);
    EXPECT_EQ(thrown->code, ErrorCode::kOutput);
    EXPECT_THAT(thrown->message, HasSubstr("/sys/a.glb"));
    EXPECT_THAT(thrown->message, HasSubstr("write to another folder"));
}

TEST(AtomicFile, KeepsAReadOnlyTarget) {
    if (::geteuid() == 0) GTEST_SKIP() << "root may write everything";
    const Folder folder;
    write_text(folder / "a", "old");
    std::filesystem::permissions(folder / "a", std::filesystem::perms::owner_read);
    EXPECT_EQ(error_of([&] { AtomicFile file(folder / "a"); })->code, ErrorCode::kOutput);
    EXPECT_EQ(read_text(folder / "a"), "old");
}

}  // namespace
}  // namespace pointbake
