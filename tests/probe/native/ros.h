// The classes of roscpp whose functions the probe stands before, as its public headers lay them out.
#pragma once
#include <cstddef>
#include <memory>
#include <string>

namespace boost {
template <class F>
struct function {
  void *target = nullptr;
};
}  // namespace boost

namespace ros {
struct SerializedMessage {
  int length = 0;
};

class Publisher {
 public:
  Publisher(const std::string &topic, const std::string &datatype);
  template <class M>
  void publish(const M &message) const
  {
    boost::function<SerializedMessage(void)> serialize{const_cast<M *>(&message)};
    SerializedMessage serialized;
    publish(serialize, serialized);
  }
  void publish(const boost::function<SerializedMessage(void)> &serialize, SerializedMessage &m) const;

 private:
  struct Impl {
    std::string topic_, md5sum_, datatype_;
  };
  std::shared_ptr<Impl> impl_;
};

class ServiceClient {
 public:
  explicit ServiceClient(const std::string &name);
  bool call(const SerializedMessage &request, SerializedMessage &response, const std::string &md5sum);

 private:
  struct Impl {
    std::shared_ptr<int> server_link_;
    std::string name_;
  };
  std::shared_ptr<Impl> impl_;
};
}  // namespace ros

extern "C" {
int rcl_publish(const void *publisher, const void *message, void *allocation);
int rcl_publish_serialized_message(const void *publisher, const void *message, void *allocation);
int rcl_publish_loaned_message(const void *publisher, void *message, void *allocation);
int rcl_send_request(const void *client, const void *request, long *number);
int rcl_action_send_goal_request(const void *client, const void *request, long *number);
int rcl_publisher_init(void *, const void *node, const void *type, const char *, const void *qos);
int rcl_publisher_fini(void *, void *node);
int rcl_subscription_init(void *, const void *node, const void *type, const char *, const void *qos);
int rcl_client_init(void *, const void *node, const void *type, const char *, const void *options);
int rcl_service_init(void *, const void *node, const void *type, const char *, const void *options);
int rcl_init(int argc, const char *const *argv, const void *options, void *context);
int rcl_init_options_set_domain_id(void *options, size_t domain);
}
