// A robot of the domain NAMESPACE that asks on standard output what it does, as tools/peers/behavior_trees/runner.cpp says.
namespace longstep::NAMESPACE {

template <typename Result>
class Asked final : public Task<Result> {
 public:
  using Named = std::optional<Result> (*)(const std::string&);
  Asked(std::string call, Named named)
      : call_(std::move(call)), named_(named), first_(scripted::answer("do\t" + call_)) {
    if (first_ == "exception") throw std::runtime_error("exception");
  }
  Poll<Result> poll() override {
    const std::string line = first_.empty() ? scripted::answer("still\t" + call_) : std::exchange(first_, "");
    if (line == "halt") scripted::halts = true;
    if (line == "later" || line == "halt") return Running{};
    if (line == "failure") return Failed{};
    const auto tab = line.find('\t');
    const auto result = named_(tab == std::string::npos ? "" : line.substr(tab + 1));
    if (!result) std::exit(4);
    return *result;
  }
  void halt() override { scripted::tell("halted\t" + call_); }

 private:
  std::string call_;
  Named named_;
  std::string first_;
};

class Scripted final : public Robot {
 public:
FUNCTIONS};

}  // namespace longstep::NAMESPACE
