#include "ros/node/xmlrpc_call.h"

#include <xmlrpcpp/XmlRpcClient.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>

namespace raven2_trainer::ros_bridge {
namespace {

using Value = XmlRpc::XmlRpcValue;

constexpr int kSuccess = 1;            // of the three codes of the ROS APIs
constexpr std::size_t kTogether = 50;  // calls in a message: of kPatience, 60 ms are left for each

class TimedClient : public XmlRpc::XmlRpcClient {
 public:
  using XmlRpc::XmlRpcClient::XmlRpcClient;

  bool callWithin(double seconds, const char* method, const Value& arguments, Value* answer) {
    if (!executeNonBlock(method, arguments)) return false;
    _disp.work(seconds);  // returns when the answer is whole, the connection is gone, or the time is over
    return executeCheckDone(*answer) && !isFault();
  }
};

std::optional<Value> payload(Value& answer) {
  if (answer.getType() != Value::TypeArray || answer.size() != 3) return {};
  if (answer[0].getType() != Value::TypeInt || static_cast<int>(answer[0]) != kSuccess) return {};
  return answer[2];
}

Value listOf(const std::vector<Value>& values) {
  Value list;
  list.setSize(static_cast<int>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i)
    list[static_cast<int>(i)] = values[i];
  return list;
}

std::optional<Value> answerTo(const std::string& host,
                              std::uint32_t port,
                              const std::string& method,
                              const Value& arguments,
                              double patience) {
  Value answer;
  TimedClient client(host.c_str(), static_cast<int>(port), "/");
  const bool answered = client.callWithin(patience, method.c_str(), arguments, &answer);
  client.close();
  if (!answered) return {};
  return answer;
}

/** Each answer is a list of one value, or a structure if the call failed. */
bool takePayloads(Value& answers, std::size_t count, std::vector<Value>& payloads) {
  if (answers.getType() != Value::TypeArray || answers.size() != static_cast<int>(count)) return false;
  for (int i = 0; i < answers.size(); ++i) {
    if (answers[i].getType() != Value::TypeArray || answers[i].size() != 1) return false;
    const std::optional<Value> value = payload(answers[i][0]);
    if (!value) return false;
    payloads.push_back(*value);
  }
  return true;
}

}  // namespace

std::optional<Value> call(const std::string& host,
                          std::uint32_t port,
                          const std::string& method,
                          const std::vector<Value>& arguments,
                          double patience) {
  std::optional<Value> answer = answerTo(host, port, method, listOf(arguments), patience);
  return answer ? payload(*answer) : std::nullopt;
}

std::optional<std::vector<Value>> callAll(const std::string& host,
                                          std::uint32_t port,
                                          const std::vector<MasterCall>& requests,
                                          double patience) {
  std::vector<Value> payloads;
  for (std::size_t begin = 0; begin < requests.size(); begin += kTogether) {
    const std::size_t count = std::min(kTogether, requests.size() - begin);
    Value calls;
    for (std::size_t i = 0; i < count; ++i) {
      calls[static_cast<int>(i)]["methodName"] = requests[begin + i].method;
      calls[static_cast<int>(i)]["params"] = listOf(requests[begin + i].arguments);
    }
    std::optional<Value> answers = answerTo(host, port, "system.multicall", listOf({calls}), patience);
    if (!answers || !takePayloads(*answers, count, payloads)) return {};
  }
  return payloads;
}

}  // namespace raven2_trainer::ros_bridge
