#include <array>
#include <map>
#include <vector>

#include "ros.h"

static ros::Publisher out("/out", "std_msgs/Int32");

template <typename T>
void send(T value)
{
  int number = static_cast<int>(value);
  out.publish(number);
}

template <>
void send<char>(char)
{
  out.publish(1);
}

template <class T, int N = 3>
class Queue {
 public:
  explicit Queue(T first) : first_(first) { send(first_); }
  void push(const std::map<int, std::vector<T>> &values);
  template <class U>
  U pop(U otherwise);

 private:
  T first_;
};

template <class T, int N>
void Queue<T, N>::push(const std::map<int, std::vector<T>> &values)
{
  send(values.size());
}

template <class T, int N>
template <class U>
U Queue<T, N>::pop(U otherwise)
{
  out.publish(N);
  return otherwise;
}

template <>
void Queue<double, 7>::push(const std::map<int, std::vector<double>> &)
{
  out.publish(7);
}

template <class... Values>
void all(Values... values)
{
  for (int value : {static_cast<int>(values)...}) send(value);
}

template <class T>
std::vector<std::array<T, (sizeof(T) > 2)>> plan(T)
{
  out.publish(5);
  return {};
}

int main()
{
  Queue<double> queue(1.0);
  queue.push({});
  queue.pop<std::vector<int>>({});
  Queue<double, 7>(2.0).push({});
  send('a');
  all(1, 2.0, 'c');
  plan(3L);
}
