#include "core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <string>

#include "core/hash.h"
#include "core/parallel_sort.h"
#include "pointbake/error.h"

namespace pointbake {
namespace {

Context with_threads(int threads) {
    Context context;
    context.threads = threads;
    return context;
}

TEST(Parallel, CoversEachIndexOnce) {
    for (const int threads : {1, 2, 7}) {
        for (const std::size_t count : {0U, 1U, 99U, 100U, 101U, 12345U}) {
            std::vector<std::atomic<int>> visits(count);
            parallel_for(with_threads(threads), count, 100,
                         [&](std::size_t begin, std::size_t end) {
                             EXPECT_LE(end - begin, 100U);
                             EXPECT_EQ(begin % 100, 0U);
                             for (std::size_t i = begin; i < end; ++i) ++visits[i];
                         });
            for (const auto& n : visits) ASSERT_EQ(n.load(), 1);
        }
    }
}

TEST(Parallel, ReducesInOrder) {
    const auto joined = [](int threads) {
        return parallel_reduce(
            with_threads(threads), 1000, 7, std::string{},
            [](std::size_t begin, std::size_t end) {
                std::string s;
                for (std::size_t i = begin; i < end; ++i) s += std::to_string(i) + ",";
                return s;
            },
            [](std::string a, const std::string& b) { return std::move(a) + b; });
    };
    std::string wanted;
    for (int i = 0; i < 1000; ++i) wanted += std::to_string(i) + ",";
    for (const int threads : {1, 2, 7}) EXPECT_EQ(joined(threads), wanted);
}

// Floating-point sums depend on their order: the same bits mean the same order.
TEST(Parallel, SumsToTheSameBitsForAnyNumberOfThreads) {
    const auto sum = [](int threads) {
        return parallel_reduce(
            with_threads(threads), 100'000, 1000, 0.0,
            [](std::size_t begin, std::size_t end) {
                double s = 0.0;
                for (std::size_t i = begin; i < end; ++i) s += random_unit(1, i) - 0.5;
                return s;
            },
            std::plus<>{});
    };
    const double one = sum(1);
    for (const int threads : {2, 3, 7}) EXPECT_EQ(sum(threads), one);
}

TEST(Parallel, CarriesExceptionsToTheCaller) {
    for (const int threads : {1, 7}) {
        try {
            parallel_for(with_threads(threads), 1000, 10, [](std::size_t begin, std::size_t) {
                if (begin == 500) throw Error(ErrorCode::kLimit, "at 500");
            });
            FAIL() << "nothing thrown";
        } catch (const Error& e) {
            EXPECT_EQ(e.code(), ErrorCode::kLimit);
            EXPECT_STREQ(e.what(), "at 500");
        }
    }
}

TEST(Parallel, StopsWhenTold) {
    for (const int threads : {1, 2, 7}) {
        std::stop_source source;
        Context context = with_threads(threads);
        context.stop = source.get_token();
        std::atomic<int> num_chunks = 0;
        try {
            parallel_for(context, 100'000, 1, [&](std::size_t, std::size_t) {
                if (++num_chunks == 10) source.request_stop();
            });
            FAIL() << "not cancelled";
        } catch (const Error& e) {
            EXPECT_EQ(e.code(), ErrorCode::kCancelled);
        }
        EXPECT_LT(num_chunks.load(), 1000);
    }
}

TEST(Parallel, StopsEvenWithoutWork) {
    std::stop_source source;
    Context context;
    context.stop = source.get_token();
    parallel_for(context, 0, 1, [](std::size_t, std::size_t) {});
    source.request_stop();
    EXPECT_THROW(parallel_for(context, 0, 1, [](std::size_t, std::size_t) {}), Error);
    EXPECT_THROW(check_cancelled(context), Error);
}

TEST(Parallel, SortsTheSameForAnyNumberOfThreads) {
    std::vector<std::uint64_t> values(20'000);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = hash64(3, i) % 1000 * 100'000 + i;
    std::vector<std::uint64_t> wanted = values;
    std::sort(wanted.begin(), wanted.end());
    for (const int threads : {1, 2, 7}) {
        std::vector<std::uint64_t> sorted = values;
        parallel_sort(with_threads(threads), sorted);
        EXPECT_EQ(sorted, wanted);
    }
}

}  // namespace
}  // namespace pointbake
