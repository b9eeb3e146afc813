#include <memory>

#include "ros.h"

static ros::Publisher out("/out", "std_msgs/Int32");

struct Named {
  virtual ~Named() = default;
  virtual void name() = 0;
};

struct Stage {
  virtual ~Stage() { out.publish(0); }
  virtual void run() { out.publish(1); }
};

class Pick final : public Named, public virtual Stage {
 public:
  void name() override { out.publish(2); }
  void run() override
  {
    Stage::run();
    out.publish(3);
  }
};

template <class Derived>
struct Base {
  void start() { static_cast<Derived *>(this)->act(); }
};

struct Place : Base<Place> {
  void act() { out.publish(4); }
};

static void visit(Named &named, Stage &stage)
{
  named.name();
  stage.run();
}

int main()
{
  auto pick = std::make_unique<Pick>();
  visit(*pick, *pick);
  Place().start();
}
