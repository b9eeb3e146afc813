#include "gripper.h"

static void pick(hand::Gripper &gripper)
{
  gripper.open();
  gripper.close();
}

int main()
{
  hand::Gripper gripper;
  pick(gripper);
}
