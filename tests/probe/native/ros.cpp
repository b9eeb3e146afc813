// What stands behind the probe: messages whose target says so throw, all others are counted.
#include "ros.h"

#include <atomic>
#include <cstring>
#include <stdexcept>

static std::atomic<long> sent;
extern "C" long ros_sent() { return sent; }

namespace ros {
Publisher::Publisher(const std::string &topic, const std::string &datatype)
    : impl_(new Impl{topic, "*", datatype})
{
}
void Publisher::publish(const boost::function<SerializedMessage(void)> &serialize,
                        SerializedMessage &m) const
{
  ++sent;
  if (*static_cast<int *>(serialize.target) < 0) throw std::runtime_error(impl_->topic_);
  ++m.length;
}
ServiceClient::ServiceClient(const std::string &name) : impl_(new Impl{nullptr, name}) {}
bool ServiceClient::call(const SerializedMessage &request, SerializedMessage &, const std::string &)
{
  ++sent;
  if (request.length < 0) throw std::runtime_error(impl_->name_);
  return true;
}
}  // namespace ros

// Of rcl, a handle is here the name of what it is for.
extern "C" {
const char *rcl_publisher_get_topic_name(const void *it) { return (const char *)it; }
const char *rcl_client_get_service_name(const void *it) { return (const char *)it; }
const char *rcl_subscription_get_topic_name(const void *it) { return (const char *)it; }
const char *rcl_service_get_service_name(const void *it) { return (const char *)it; }
const char *rcl_node_get_fully_qualified_name(const void *it) { return (const char *)it; }
static long errors;
void rcutils_reset_error() { ++errors; }
#define MADE(kind)                                                                               \
  int rcl_##kind##_init(void *self, const void *, const void *, const char *name, const void *)  \
  {                                                                                              \
    std::strcpy((char *)self, name);                                                             \
    return name[0] != '/';                                                                       \
  }                                                                                              \
  int rcl_##kind##_fini(void *, void *) { return 20; }
MADE(publisher)
MADE(subscription)
MADE(client)
MADE(service)
int rcl_init(int argc, const char *const *argv, const void *, void *context)
{
  std::string words;
  for (int at = 0; at < argc; ++at) words += std::string(argv[at]) + ";";
  std::strcpy((char *)context, words.c_str());
  return argc;
}
int rcl_init_options_set_domain_id(void *options, size_t domain)
{
  return *(size_t *)options = domain, 0;
}
int rcl_publish(const void *, const void *, void *) { return 10 + (int)++sent; }
int rcl_publish_serialized_message(const void *, const void *, void *) { return 10 + (int)++sent; }
int rcl_publish_loaned_message(const void *, void *, void *) { return 10 + (int)++sent; }
int rcl_send_request(const void *, const void *, long *number) { return *number = 77, 10 + (int)++sent; }
int rcl_action_send_goal_request(const void *it, const void *request, long *number)
{
  // The name of the client is as the node gave it, that of its service is resolved.
  std::string service = "/cell/" + std::string((const char *)it) + "/_action/send_goal";
  return rcl_send_request(service.c_str(), request, number);
}
}
