// A node of the installed roscpp: a message, a call of a service that nobody serves, timers, a thread.
#include <ros/ros.h>
#include <roscpp/GetLoggers.h>
#include <std_msgs/Float64.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <future>
#include <mutex>
#include <thread>

class Cell {
 public:
  void swing(double angle)
  {
    std_msgs::Float64 message;
    message.data = angle;
    arm_.publish(message);
  }
  void on_timer(const ros::TimerEvent &)
  {
    ros::Duration(0.05).sleep();
    swing(2);
  }
  void on_last_timer(const ros::TimerEvent &) { ros::shutdown(); }
  bool ask()
  {
    roscpp::GetLoggers service;
    return loggers_.call(service);
  }
  ros::NodeHandle node;

 private:
  ros::Publisher arm_ = node.advertise<std_msgs::Float64>("/arm/command", 5);
  ros::ServiceClient loggers_ = node.serviceClient<roscpp::GetLoggers>("/none");
};

int main(int argc, char **argv)
{
  ros::init(argc, argv, "cell");
  Cell cell;
  ros::AsyncSpinner spinner(2);
  spinner.start();
  cell.swing(1);
  std::printf("called %d\n", cell.ask());
  ros::Timer timer = cell.node.createTimer(ros::Duration(0.05), &Cell::on_timer, &cell, true);
  ros::Timer last = cell.node.createTimer(ros::Duration(1.2), &Cell::on_last_timer, &cell, true);
  std::thread worker([&cell] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    cell.swing(3);
    std::mutex mutex;
    std::unique_lock<std::mutex> lock(mutex);
    std::condition_variable never;
    never.wait_for(lock, std::chrono::milliseconds(150));
    std::promise<void> none;
    none.get_future().wait_for(std::chrono::milliseconds(150));
  });
  ros::waitForShutdown();
  worker.join();
}
