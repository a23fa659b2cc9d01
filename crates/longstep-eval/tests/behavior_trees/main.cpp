// Ticks behavior trees with the robots of generated headers: `nodes DOMAIN`. The language on standard input and output is that of
// tools/peers/behavior_trees/runner.cpp; the answer `exception` throws one.
int main(int, char** words) {
    std::string path;
    while (std::getline(std::cin, path)) {
        try {
            BT::BehaviorTreeFactory factory;
            scripted::register_domain(words[1], factory);
            auto tree = factory.createTreeFromFile(path);
            scripted::halts = false;
            try {
                auto status = tree.tickOnce();
                while (status == BT::NodeStatus::RUNNING && !scripted::halts) status = tree.tickOnce();
                if (scripted::halts) tree.haltTree();
                scripted::tell("end\t" + (scripted::halts ? "HALTED" : BT::toStr(status)));
            } catch (const std::exception& error) {
                if (std::string(error.what()).find("exception") == std::string::npos) throw;
                scripted::tell("end\tEXCEPTION");
            }
        } catch (const std::exception& error) {
            scripted::tell(std::string("refused\t") + error.what());
        }
    }
}
