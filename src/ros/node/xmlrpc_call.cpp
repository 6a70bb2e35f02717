#include "ros/node/xmlrpc_call.h"

#include <xmlrpcpp/XmlRpcClient.h>
#include <xmlrpcpp/XmlRpcException.h>

namespace raven2_trainer::ros_bridge {
namespace {

constexpr int kSuccess = 1;  // of the three codes of the ROS APIs

class TimedClient : public XmlRpc::XmlRpcClient {
 public:
  using XmlRpc::XmlRpcClient::XmlRpcClient;

  bool callWithin(double seconds,
                  const char* method,
                  const XmlRpc::XmlRpcValue& arguments,
                  XmlRpc::XmlRpcValue* answer) {
    if (!executeNonBlock(method, arguments)) return false;
    _disp.work(seconds);  // returns when the answer is whole, the connection is gone, or the time is over
    return executeCheckDone(*answer) && !isFault();
  }
};

std::optional<XmlRpc::XmlRpcValue> payload(XmlRpc::XmlRpcValue& answer) {
  if (answer.getType() != XmlRpc::XmlRpcValue::TypeArray || answer.size() != 3) return {};
  if (answer[0].getType() != XmlRpc::XmlRpcValue::TypeInt || static_cast<int>(answer[0]) != kSuccess) return {};
  return answer[2];
}

}  // namespace

std::optional<XmlRpc::XmlRpcValue> call(const std::string& host,
                                        std::uint32_t port,
                                        const std::string& method,
                                        const std::vector<XmlRpc::XmlRpcValue>& arguments,
                                        double patience) {
  XmlRpc::XmlRpcValue list, answer;
  list.setSize(static_cast<int>(arguments.size()));
  for (std::size_t i = 0; i < arguments.size(); ++i)
    list[static_cast<int>(i)] = arguments[i];
  TimedClient client(host.c_str(), static_cast<int>(port), "/");
  const bool answered = client.callWithin(patience, method.c_str(), list, &answer);
  client.close();
  if (!answered) return {};
  return payload(answer);
}

}  // namespace raven2_trainer::ros_bridge
