#include <algorithm>
#include <functional>
#include <thread>
#include <vector>

#include "ros.h"

static ros::Publisher out("/out", "std_msgs/Int32");
static std::vector<std::function<void(int)>> callbacks;

static const auto at_file_scope = [](int value) { out.publish(value); };

namespace arm {
class Cell {
 public:
  void subscribe()
  {
    callbacks.push_back([this](int value) {
      auto twice = [&](auto factor) {
        out.publish(value);
        return factor * 2;
      };
      last_ = twice(value);
    });
  }
  int each(const std::vector<int> &values) const
  {
    std::for_each(values.begin(), values.end(), [](int value) { out.publish(value); });
    return [&] {
      out.publish(last_);
      return 1;
    }();
  }

 private:
  int last_ = 0;
};
}  // namespace arm

template <class F>
void repeat(F act)
{
  act(1);
  act(2);
}

int main()
{
  arm::Cell cell;
  cell.subscribe();
  for (auto &callback : callbacks) callback(3);
  cell.each({1, 2});
  repeat([](int value) { out.publish(value); });
  std::thread([] { out.publish(4); }).join();
  at_file_scope(5);
}
