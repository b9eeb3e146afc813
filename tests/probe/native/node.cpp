// A node that issues commands and ends in many ways; its argument says which.
#include <pthread.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "ros.h"

#define APART __attribute__((noinline))
extern "C" long ros_sent();

static volatile int after;

class Cell {
 public:
  APART void swing(int angle)
  {
    arm_.publish(angle);
    ++after;
  }
  APART void home()
  {
    swing(0);
    ++after;
  }
  APART void reach(int goal)
  {
    goal_.publish(goal);
    ++after;
  }
  APART bool grip(int force)
  {
    ros::SerializedMessage request, response;
    request.length = force;
    bool is_done = gripper_.call(request, response, "*");
    ++after;
    return is_done;
  }

 private:
  ros::Publisher arm_{"/arm/command", "std_msgs/Float64"};
  ros::Publisher goal_{"/arm/goal", "control_msgs/FollowJointTrajectoryActionGoal"};
  ros::ServiceClient gripper_{"/gripper/set"};
};

// As rosidl and rmw describe types and qualities.
struct Members {
  const char *space, *name;
};
struct Type {
  const char *language;
  const void *members;
  const Type *(*in)(const Type *, const char *);
};
struct Qos {
  int history;
  size_t depth;
  int reliability, durability;
};
static const Type *described(const Type *, const char *language)
{
  static const Members members = {"std_msgs::msg", "Float64"};
  static const Type type = {language, &members, nullptr};
  return std::strcmp(language, "rosidl_typesupport_introspection_cpp") ? nullptr : &type;
}

APART void dive(Cell &cell, int depth)
{
  if (depth == 0)
    cell.home();
  else
    dive(cell, depth - 1);
  ++after;
}

static int says(const char *text)
{
  std::printf("%s %ld\n", text, ros_sent());
  std::fflush(stdout);
  return 0;
}

int main(int argc, char **argv)
{
  Cell cell;
  std::string way = argc > 1 ? argv[1] : "return";
  int count = argc > 2 ? std::atoi(argv[2]) : 1;
  if (way == "kinds") {
    cell.home();
    cell.reach(1);
    cell.grip(1);
    ros::Publisher plain("/move_base_simple/goal", "geometry_msgs/PoseStamped");
    plain.publish(1);
    return says("kinds");
  }
  if (way == "throw") {
    int caught = 0;
    try {
      cell.swing(-1);
    } catch (const std::runtime_error &error) {
      caught += !std::strcmp(error.what(), "/arm/command");
    }
    try {
      cell.grip(-1);
    } catch (const std::runtime_error &error) {
      caught += !std::strcmp(error.what(), "/gripper/set");
    }
    cell.home();
    return caught == 2 ? says("caught") : 1;
  }
  if (way == "threads") {
    std::vector<std::thread> threads;
    for (int thread = 0; thread < 16; ++thread)
      threads.emplace_back([&] {
        for (int turn = 0; turn < count; ++turn) cell.home();
      });
    for (std::thread &thread : threads) thread.join();
    return says("joined");
  }
  if (way == "fork") {
    cell.home();
    pid_t child = fork();
    cell.swing(1);
    if (child == 0) {
      cell.reach(1);
      _exit(0);
    }
    int status = 1;
    waitpid(child, &status, 0);
    return status;
  }
  if (way == "deep") {
    dive(cell, count);
    return 0;
  }
  if (way == "ros2") {
    long number = 0;
    int message = 0;
    const char *topic = "/arm/command", *service = "/gripper/set", *action = "arm/move";
    bool is_right = rcl_publish(topic, &message, nullptr) == 11 &&
                    rcl_publish_serialized_message(topic, &message, nullptr) == 12 &&
                    rcl_publish_loaned_message(topic, &message, nullptr) == 13 &&
                    rcl_send_request(service, &message, &number) == 14 && number == 77 &&
                    rcl_action_send_goal_request(action, &message, &number) == 15;
    return is_right ? 0 : 1;
  }
  if (way == "ends") {
    const Type type = {"rosidl_typesupport_cpp", nullptr, described};
    const Type plain = {"unknown", nullptr, described};
    const Qos kept = {1, 10, 2, 1}, usual = {1, 10, 1, 2};
    char node[] = "/cell", topic[99], other[99], client[99], service[99], bad[99];
    int code = rcl_publisher_init(topic, node, &type, "/speed", &kept) +
               rcl_subscription_init(other, node, &type, "/states", &usual) +
               rcl_client_init(client, node, &type, "/grip", nullptr) +
               rcl_service_init(service, node, &type, "/stop", nullptr);
    bool is_right = code == 0 && rcl_publisher_init(bad, node, &type, "no name", &kept) == 1 &&
                    rcl_publisher_init(bad, node, &plain, "/unknown", &kept) == 0 &&
                    rcl_publisher_fini(topic, node) == 20;
    return is_right ? 0 : 1;
  }
  if (way == "publishers") {
    const Type type = {"rosidl_typesupport_cpp", nullptr, described};
    const Qos kept = {1, 10, 2, 1};
    char node[] = "/cell", one[99], other[99];
    int message = 0, code = rcl_publisher_init(one, node, &type, "/speed", &kept) +
                            rcl_publisher_init(other, node, &type, "/speed", &kept);
    for (char *publisher : {one, other, other, one}) rcl_publish(publisher, &message, nullptr);
    rcl_publisher_fini(one, node);
    code += rcl_publisher_init(one, node, &type, "/speed", &kept);
    rcl_publish(one, &message, nullptr);
    return code;
  }
  if (way == "arguments") {
    char words[999];
    const char *const given[] = {"node", "left"};
    size_t domain = 0;
    rcl_init_options_set_domain_id(&domain, 7);
    int n_words = rcl_init(2, given, nullptr, words);
    std::printf("%d %s %d\n", n_words, words, domain == 7);
    std::fflush(stdout);
    return rcl_init(0, nullptr, nullptr, words);
  }
  if (way == "truncate") {
    cell.home();
    if (truncate(std::getenv("TRACERISK_CALLS"), 0)) return 1;
    cell.home();
    return says("went on");
  }
  if (way == "closes") {
    for (int file = 3; file < 64; ++file) close(file);
    for (int turn = 0; turn < 2000; ++turn) cell.home();
    return says("closed");
  }
  if (way == "handler") {  // a signal's handler that publishes while the node does
    static Cell *own = &cell;
    struct sigaction action = {};
    action.sa_handler = [](int) { own->swing(2); };
    sigaction(SIGALRM, &action, nullptr);
    ualarm(500, 500);
    for (int turn = 0; turn < count; ++turn) cell.home();
    ualarm(0, 0);
    return says("handled");
  }
  for (int turn = 0; turn < count; ++turn) cell.home();
  if (way == "exit") std::exit(3);
  if (way == "_exit") _exit(4);
  if (way == "abort") std::abort();
  if (way == "terminate") throw 1;
  if (way == "segv") raise(SIGSEGV);
  if (way == "kill") raise(SIGKILL);
  if (way == "term") raise(SIGTERM);
  if (way == "int") raise(SIGINT);
  if (way == "quick") std::quick_exit(5);
  if (way == "exec") {
    execl("/proc/self/exe", argv[0], "return", nullptr);
    return 1;
  }
  return says("returns");
}
