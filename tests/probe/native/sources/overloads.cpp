#include <stdexcept>
#include <utility>

#include "ros.h"

static ros::Publisher out("/out", "std_msgs/Int32");

struct Arm {
  void go(int joint) { out.publish(joint); }
  void go(double angle, bool is_slow = true) noexcept;
  int where() const & { return out.publish(1), 1; }
  int where() && { return out.publish(2), 2; }
  auto state() const -> std::pair<int, int>
  {
    out.publish(3);
    return {0, 0};
  }
  Arm();
  explicit Arm(int number);
  ~Arm() { out.publish(9); }
};

void Arm::go(double angle, bool is_slow) noexcept
{
  out.publish(is_slow ? static_cast<int>(angle) : 0);
}

Arm::Arm() try : Arm(1) {
  out.publish(4);
} catch (const std::runtime_error &) {
  throw;
}

Arm::Arm(int number)
{
  out.publish(number);
}

int *(choose)(Arm &arm, int *const numbers)
{
  arm.go(5);
  return numbers;
}

void (*pick(int number))(int)
{
  out.publish(number);
  return nullptr;
}

[[nodiscard]] static inline unsigned long long count(void)
{
  out.publish(8);
  return 1;
}

int main()
{
  Arm arm;
  arm.go(1);
  arm.go(2.0);
  int numbers[] = {arm.where() + std::move(arm).where() + arm.state().first};
  choose(arm, numbers);
  pick(6);
  return count() == 1 ? 0 : 1;
}
