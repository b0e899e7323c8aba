#include "sinew/common/worker_team.h"

#include <gtest/gtest.h>

#include <numeric>

namespace sinew {
namespace {

TEST(WorkerTeamTest, EveryMemberWorksOnceARun) {
  for (const int size : {1, 2, 5}) {
    WorkerTeam team(size);
    ASSERT_EQ(team.size(), size);
    std::vector<int> calls(static_cast<std::size_t>(size), 0);
    for (int run = 1; run <= 500; ++run) {
      team.run([&](int member) { ++calls[member]; });
      EXPECT_EQ(calls, std::vector<int>(calls.size(), run));  // all have, and the caller sees it
    }
  }
}

TEST(WorkerTeamTest, TheCallerIsMemberZero) {
  WorkerTeam team(3);
  std::vector<std::thread::id> threads(3);
  team.run([&](int member) { threads[member] = std::this_thread::get_id(); });
  EXPECT_EQ(threads[0], std::this_thread::get_id());
  EXPECT_NE(threads[1], threads[0]);
  EXPECT_NE(threads[2], threads[1]);
}

// Without privileges a thread may call itself a batch job: enough to see that the others follow.
TEST(WorkerTeamTest, WorksByTheSchedulingOfTheCaller) {
  WorkerTeam team(2);
  int policy = -1;
  const auto look = [&policy](int member) {
    sched_param parameters{};
    if (member == 1) pthread_getschedparam(pthread_self(), &policy, &parameters);
  };
  team.run(look);
  EXPECT_EQ(policy, SCHED_OTHER);
  std::thread([&] {
    const sched_param parameters{};
    ASSERT_EQ(pthread_setschedparam(pthread_self(), SCHED_BATCH, &parameters), 0);
    team.run(look);
  }).join();
  EXPECT_EQ(policy, SCHED_BATCH);
}

TEST(WorkerTeamTest, EndsWithoutEverHavingWorked) {
  const WorkerTeam team(4);
}

}  // namespace
}  // namespace sinew
