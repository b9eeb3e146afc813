#include <cstddef>
#include <string>
#include <vector>

#include "ros.h"

static ros::Publisher out("/out", "std_msgs/Int32");

struct Step {
  void operator()(double) const { out.publish(1); }
  int operator[](int index) { return out.publish(index), index; }
  Step *operator->()
  {
    out.publish(2);
    return this;
  }
  Step &operator+=(const Step &)
  {
    out.publish(3);
    return *this;
  }
  Step operator-() const;
  bool operator<(const Step &) const { return out.publish(4), true; }
  bool operator>(const Step &) const { return out.publish(4), true; }
  Step &operator++() { return out.publish(5), *this; }
  explicit operator bool() const { return out.publish(6), true; }
  operator double() const;
  operator std::string() const { return out.publish(7), ""; }
  operator std::vector<int>() const { return out.publish(7), std::vector<int>(); }
  void *operator new(std::size_t) { return out.publish(8), &space; }
  void operator delete(void *) { out.publish(9); }
  void operator delete[](void *) { out.publish(9); }
  static int space[4];
};
int Step::space[4];

Step Step::operator-() const
{
  out.publish(10);
  return *this;
}

Step::operator double() const
{
  out.publish(11);
  return 1;
}

template <class T>
struct Box {
  Box operator*(const Box &) const;
  Box &operator<<(T);
};

template <class T>
Box<T> Box<T>::operator*(const Box<T> &) const
{
  out.publish(12);
  return *this;
}

template <class T>
Box<T> &Box<T>::operator<<(T)
{
  out.publish(13);
  return *this;
}

template <class T>
bool operator==(const Box<T> &, const Box<T> &)
{
  return out.publish(14), true;
}

namespace angle {
double operator""_deg(long double value)
{
  out.publish(15);
  return static_cast<double>(value);
}
}  // namespace angle

int main()
{
  using namespace angle;
  Step step;
  step(1.0);
  step[1];
  step->space[0] = 1;
  step += -step;
  bool all = step < step && step > step && static_cast<bool>(++step);
  double number = step;
  std::string text = step;
  std::vector<int> numbers = step;
  delete new Step;
  Step::operator delete[](nullptr);
  Box<int> box;
  box << 1 << 2;
  return box == box * box && all && number == 1 && text.empty() && numbers.empty() && 1.0_deg == 1 ? 0 : 1;
}
