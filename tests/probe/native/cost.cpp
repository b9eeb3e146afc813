// What a publish costs at several depths of the stack: lines of depth and microseconds of processor
// time, the least of many rounds.
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "ros.h"

static volatile int after;

static double seconds()
{
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

__attribute__((noinline)) static void publish_at(int depth, const ros::Publisher &arm)
{
  if (depth == 1)
    arm.publish(depth);
  else
    publish_at(depth - 1, arm);
  ++after;
}

int main(int, char **argv)
{
  const ros::Publisher arm("/arm/command", "std_msgs/Float64");
  const int turns = 500, rounds = std::atoi(argv[1]);
  for (int depth : {1, 5, 10, 20}) {
    double least = 1e9;
    for (int round = 0; round < rounds; ++round) {
      double begin = seconds();
      for (int turn = 0; turn < turns; ++turn) publish_at(depth, arm);
      least = std::min(least, (seconds() - begin) / turns * 1e6);
    }
    std::printf("%d %.4f\n", depth, least);
  }
}
