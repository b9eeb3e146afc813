#include <functional>
#include <memory>

#include "ros.h"

static ros::Publisher out("/out", "std_msgs/Int32");

class Node {
 public:
  void on_state(const std::shared_ptr<const int> &state) { out.publish(*state); }
  void on_timer(int *counter) const;
  static void on_signal(int number);

 private:
  friend void on_end(Node &);
  void end() { out.publish(4); }
};

void Node::on_timer(int *counter) const
{
  out.publish(++*counter);
}

void Node::on_signal(int number)
{
  out.publish(number);
}

void on_end(Node &node)
{
  node.end();
}

void spin(const std::function<void()> &callback)
{
  callback();
}

int main()
{
  Node node;
  int counter = 1;
  spin(std::bind(&Node::on_state, &node, std::make_shared<const int>(1)));
  spin(std::bind(&Node::on_timer, &node, &counter));
  void (*handler)(int) = &Node::on_signal;
  handler(3);
  spin(std::bind(on_end, std::ref(node)));
}
