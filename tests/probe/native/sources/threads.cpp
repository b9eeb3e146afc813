#include <future>
#include <mutex>
#include <thread>

#include "ros.h"

static ros::Publisher out("/out", "std_msgs/Int32");

class Worker {
 public:
  void start()
  {
    out.publish(1);
    thread_ = std::thread(&Worker::loop, this, 2);
  }
  ~Worker()
  {
    thread_.join();
    out.publish(2);
  }

 private:
  void loop(int turns)
  {
    for (int turn = 0; turn < turns; ++turn) step(turn);
  }
  void step(int turn)
  {
    std::lock_guard<std::mutex> guard(mutex_);
    out.publish(turn);
  }
  std::thread thread_;
  std::mutex mutex_;
};

static int plan(int number)
{
  out.publish(number);
  return number;
}

int main()
{
  out.publish(3);
  std::future<int> later = std::async(std::launch::async, plan, 5);
  std::call_once(*new std::once_flag, [] { out.publish(4); });
  Worker worker;
  worker.start();
  return later.get() == 5 ? 0 : 1;
}
