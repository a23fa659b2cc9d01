namespace detail {

using Texts = std::vector<std::string>;

/// Ends an action that has begun.
class Ending {
 public:
  virtual ~Ending() = default;
  virtual void end() = 0;
};

/// The actions that have begun and have not ended.
struct Session {
  std::shared_ptr<Robot> robot;
  std::vector<Ending*> begun;

  /// Calls the robot. An exception halts everything that has begun, and leaves the tick.
  template <typename Call>
  auto guarded(Call call) -> decltype(call()) {
    try {
      return call();
    } catch (...) {
      halt_all();
      throw;
    }
  }

  /// Halts everything that has begun, also if one of them throws.
  void halt_all() noexcept {
    while (!begun.empty()) {
      Ending* last = begun.back();
      begun.pop_back();
      try {
        last->end();
      } catch (...) {
        // The exception that is on its way says what is wrong.
      }
    }
  }

  void forget(const Ending* ending) { begun.erase(std::remove(begun.begin(), begun.end(), ending), begun.end()); }
};

inline Texts arguments(const BT::TreeNode& node, const Texts& ports) {
  Texts texts;
  for (const auto& port : ports) {
    const auto text = node.getInput<std::string>(port);
    if (!text) throw BT::RuntimeError("the node [", node.registrationName(), "] has no text for the port [", port, "]");
    texts.push_back(*text);
  }
  return texts;
}

/// Returns a text as a part of an outcome's word.
inline std::string word_part(const std::string& text) {
  const auto first = text.find_first_not_of("<>");
  if (first == std::string::npos) return "";
  std::string part;
  for (const char character : text.substr(first, text.find_last_not_of("<>") + 1 - first)) {
    const auto byte = static_cast<unsigned char>(character);
    const bool is_plain = byte < 0x80 && (std::isalnum(byte) != 0 || byte == '_' || byte == '-');
    // The bytes that continue a letter outside of ASCII.
    if ((byte & 0xC0) != 0x80) part += is_plain ? character : '_';
  }
  return part;
}

/// Returns the words for outcomes, each different from those before it.
inline Texts outcome_words(const std::vector<Texts>& outcomes) {
  Texts words;
  for (const auto& parts : outcomes) {
    std::string word;
    for (const auto& part : parts) word += (word.empty() ? "" : "_") + word_part(part);
    while (std::find(words.begin(), words.end(), word) != words.end()) word += '_';
    words.push_back(word);
  }
  return words;
}

template <typename Result>
using Begin = std::function<Begun<Result>(Robot&, const Texts&)>;
using Words = std::function<std::vector<Texts>(const Texts&)>;

template <typename Result>
class Action final : public BT::StatefulActionNode, private Ending {
 public:
  Action(const std::string& name, const BT::NodeConfig& config, std::shared_ptr<Session> session, Texts ports,
         Begin<Result> begin, Words words)
      : StatefulActionNode(name, config),
        session_(std::move(session)),
        ports_(std::move(ports)),
        begin_(std::move(begin)),
        words_(std::move(words)) {}

  ~Action() override {
    try {
      onHalted();
    } catch (...) {
      // The tree halts its nodes before it destroys them; there is nobody left who could catch this.
    }
  }

  BT::NodeStatus onStart() override {
    return session_->guarded([this] {
      arguments_ = arguments(*this, ports_);
      task_ = begin_(*session_->robot, arguments_);
      if (!task_) return BT::NodeStatus::FAILURE;
      session_->begun.push_back(this);
      return looked();
    });
  }

  BT::NodeStatus onRunning() override {
    return session_->guarded([this] { return task_ ? looked() : BT::NodeStatus::FAILURE; });
  }

  void onHalted() override {
    session_->forget(this);
    end();
  }

 private:
  BT::NodeStatus looked() {
    const Poll<Result> result = task_->poll();
    if (std::holds_alternative<Running>(result)) return BT::NodeStatus::RUNNING;
    session_->forget(this);
    task_.reset();
    if (std::holds_alternative<Failed>(result)) return BT::NodeStatus::FAILURE;
    if constexpr (std::is_enum_v<Result>) {
      const auto index = static_cast<std::size_t>(std::get<Result>(result));
      setOutput("outcome", outcome_words(words_(arguments_)).at(index));
    }
    return BT::NodeStatus::SUCCESS;
  }

  void end() override {
    const Begun<Result> task = std::move(task_);
    if (task) task->halt();
  }

  std::shared_ptr<Session> session_;
  Texts ports_;
  Begin<Result> begin_;
  Words words_;
  Texts arguments_;
  Begun<Result> task_;
};

class Condition final : public BT::ConditionNode {
 public:
  using Ask = std::function<bool(Robot&, const Texts&)>;

  Condition(const std::string& name, const BT::NodeConfig& config, std::shared_ptr<Session> session, Texts ports,
            Ask ask)
      : ConditionNode(name, config), session_(std::move(session)), ports_(std::move(ports)), ask_(std::move(ask)) {}

  BT::NodeStatus tick() override {
    const bool holds = session_->guarded([this] { return ask_(*session_->robot, arguments(*this, ports_)); });
    return holds ? BT::NodeStatus::SUCCESS : BT::NodeStatus::FAILURE;
  }

 private:
  std::shared_ptr<Session> session_;
  Texts ports_;
  Ask ask_;
};

inline BT::PortsList ports_of(const Texts& ports, bool senses) {
  BT::PortsList list;
  for (const auto& port : ports) list.insert(BT::InputPort<std::string>(port));
  if (senses) list.insert(BT::OutputPort<std::string>("outcome"));
  return list;
}

template <typename Result>
void action(BT::BehaviorTreeFactory& factory, const std::shared_ptr<Session>& session, const std::string& id,
            const Texts& ports, const Begin<Result>& begin, const Words& words = {}) {
  factory.registerBuilder({BT::NodeType::ACTION, id, ports_of(ports, std::is_enum_v<Result>), {}},
                          [=](const std::string& name, const BT::NodeConfig& config) -> std::unique_ptr<BT::TreeNode> {
                            return std::make_unique<Action<Result>>(name, config, session, ports, begin, words);
                          });
}

inline void condition(BT::BehaviorTreeFactory& factory, const std::shared_ptr<Session>& session, const std::string& id,
                      const Texts& ports, const Condition::Ask& ask) {
  factory.registerBuilder({BT::NodeType::CONDITION, id, ports_of(ports, false), {}},
                          [=](const std::string& name, const BT::NodeConfig& config) -> std::unique_ptr<BT::TreeNode> {
                            return std::make_unique<Condition>(name, config, session, ports, ask);
                          });
}

}  // namespace detail

