#include "ros.h"

static ros::Publisher out("/out", "std_msgs/Int32");

#define GUARDED(call) \
  do {                \
    call;             \
  } while (false)

extern "C" void from_c(int number) { GUARDED(out.publish(number)); }

extern "C" {
static void also_from_c(int number) { out.publish(number + 1); }
}

struct Outer {
  struct Inner {
    union Either {
      int number;
      void tell() { out.publish(number); }
    };
    static void deep() { Either{1}.tell(); }
  };
  enum class Mode { fast, slow };
  void set(Mode mode);
};

void Outer::set(Outer::Mode mode)
{
  struct Local {
    int number;
    void run() { out.publish(number); }
  };
  Local{mode == Mode::fast}.run();
}

struct Global {
  Global() { out.publish(7); }
} global;

class [[gnu::visibility("default")]] Marked {
 public:
  __attribute__((noinline)) void act() { out.publish(8); }
};

int main()
{
  from_c(1);
  also_from_c(2);
  Outer::Inner::deep();
  Outer().set(Outer::Mode::slow);
  Marked().act();
}
