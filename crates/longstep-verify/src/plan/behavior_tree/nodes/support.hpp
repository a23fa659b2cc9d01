/// An action is still being done.
struct Running {};

/// An action has failed. The tree fails then, and halts the other actions.
struct Failed {};

/// A physical action has succeeded.
struct Done {};

/// The result of a look at an action: `Running`, `Failed`, or its result.
template <typename Result>
using Poll = std::variant<Running, Failed, Result>;

/// An action that the robot has begun. Its result is `Done`, or the outcome of a sensing action.
template <typename Result>
class Task {
 public:
  Task() = default;
  Task(const Task&) = delete;
  Task& operator=(const Task&) = delete;
  virtual ~Task() = default;

  /// Returns at once. It is called with every tick until the result is not `Running`.
  virtual Poll<Result> poll() = 0;

  /// Stops the robot. It is called once if the action must end before its result; nothing moves when it returns.
  virtual void halt() = 0;
};

/// An action that has begun. None fails.
template <typename Result>
using Begun = std::unique_ptr<Task<Result>>;

/// The request that work in a thread ends.
class Stop {
 public:
  /// Returns true if the work has to stop the robot and return.
  bool requested() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return requested_;
  }

  /// Waits, but not longer than until the request. Returns true if the work has to stop the robot and return.
  template <typename Rep, typename Period>
  bool wait_for(const std::chrono::duration<Rep, Period>& duration) const {
    std::unique_lock<std::mutex> lock(mutex_);
    return changed_.wait_for(lock, duration, [this] { return requested_; });
  }

  void request() {
    const std::lock_guard<std::mutex> lock(mutex_);
    requested_ = true;
    changed_.notify_all();
  }

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  bool requested_ = false;
};

namespace detail {

template <typename Result>
class ThreadTask final : public Task<Result> {
 public:
  explicit ThreadTask(std::function<std::optional<Result>(const Stop&)> work) {
    result_ = std::async(std::launch::async, [this, work = std::move(work)] { return work(stop_); });
  }

  ~ThreadTask() override { end(); }

  Poll<Result> poll() override {
    if (result_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return Running{};
    std::optional<Result> result = result_.get();
    if (!result) return Failed{};
    return *std::move(result);
  }

  void halt() override { end(); }

 private:
  void end() {
    stop_.request();
    if (result_.valid()) result_.wait();
  }

  Stop stop_;
  std::future<std::optional<Result>> result_;
};

}  // namespace detail

/// Does an action in a thread of its own. The work returns the result, or nothing if it fails, and has to look at its
/// argument often: a halted tree waits until the work returns.
template <typename Result>
Begun<Result> in_thread(std::function<std::optional<Result>(const Stop&)> work) {
  return std::make_unique<detail::ThreadTask<Result>>(std::move(work));
}

