// Ticks behavior trees with BehaviorTree.CPP, and asks on standard output what its leaves do.
//
// Input: the path of a file with a tree, one a line. Output: `refused TEXT`, or the questions of the tree and `end STATUS`:
//
//   do ID port=value ...       an action begins; the answer is `success`, `success OUTCOME`, `failure`, `later`, or `halt`,
//                              which is `later` and halts the tree after the tick
//   still ID port=value ...    an action whose answer was `later` is ticked again; the same answers
//   halted ID port=value ...   such an action is ended; no answer
//   ask ID port=value ...      a condition; the answer is `success` or `failure`
//
// Words are separated by tabs. The leaves and their ports are those of TreeNodesModel.
#include <iostream>
#include <string>

#include "behaviortree_cpp/bt_factory.h"
#include "tinyxml2.h"

using namespace BT;

static bool halts = false;

static std::string line_of(std::string text) {
    for (char& c : text) {
        if (c == '\n' || c == '\r' || c == '\t') c = ' ';
    }
    return text;
}

static std::string call(const TreeNode& node) {
    std::string text = node.registrationName();
    for (const auto& [port, info] : node.config().manifest->ports) {
        if (info.direction() != PortDirection::INPUT) continue;
        std::string value;
        if (node.getInput(port, value)) text += "\t" + port + "=" + line_of(value);
    }
    return text;
}

static std::string answer(const std::string& question) {
    std::cout << question << std::endl;
    std::string line;
    if (!std::getline(std::cin, line)) std::exit(3);
    return line;
}

class Act : public StatefulActionNode {
  public:
    using StatefulActionNode::StatefulActionNode;
    NodeStatus onStart() override { return answered(answer("do\t" + call(*this))); }
    NodeStatus onRunning() override { return answered(answer("still\t" + call(*this))); }
    void onHalted() override { std::cout << "halted\t" << call(*this) << std::endl; }

  private:
    NodeStatus answered(const std::string& line) {
        if (line == "halt") halts = true;
        if (line == "later" || line == "halt") return NodeStatus::RUNNING;
        if (line == "failure") return NodeStatus::FAILURE;
        const auto tab = line.find('\t');
        if (tab != std::string::npos) setOutput("outcome", line.substr(tab + 1));
        return NodeStatus::SUCCESS;
    }
};

class Ask : public ConditionNode {
  public:
    using ConditionNode::ConditionNode;
    NodeStatus tick() override {
        return answer("ask\t" + call(*this)) == "success" ? NodeStatus::SUCCESS : NodeStatus::FAILURE;
    }
};

static void add_leaves(BehaviorTreeFactory& factory, const char* path) {
    tinyxml2::XMLDocument document;
    document.LoadFile(path);
    const auto* root = document.RootElement();
    const auto* model = root ? root->FirstChildElement("TreeNodesModel") : nullptr;
    if (!model) return;
    for (auto* leaf = model->FirstChildElement(); leaf; leaf = leaf->NextSiblingElement()) {
        PortsList ports;
        for (auto* port = leaf->FirstChildElement(); port; port = port->NextSiblingElement()) {
            const std::string name = port->Attribute("name");
            const bool is_input = std::string(port->Name()) == "input_port";
            ports.insert(is_input ? InputPort<std::string>(name) : OutputPort<std::string>(name));
        }
        const std::string id = leaf->Attribute("ID");
        if (std::string(leaf->Name()) == "Action") {
            factory.registerBuilder({NodeType::ACTION, id, ports, {}}, [](const std::string& name, const NodeConfig& config) {
                return std::make_unique<Act>(name, config);
            });
        } else {
            factory.registerBuilder({NodeType::CONDITION, id, ports, {}}, [](const std::string& name, const NodeConfig& config) {
                return std::make_unique<Ask>(name, config);
            });
        }
    }
}

int main() {
    std::string path;
    while (std::getline(std::cin, path)) {
        try {
            BehaviorTreeFactory factory;
            add_leaves(factory, path.c_str());
            auto tree = factory.createTreeFromFile(path);
            halts = false;
            auto status = tree.tickOnce();
            while (status == NodeStatus::RUNNING && !halts) status = tree.tickOnce();
            if (halts) tree.haltTree();
            std::cout << "end\t" << (halts ? "HALTED" : toStr(status)) << std::endl;
        } catch (const std::exception& error) {
            std::cout << "refused\t" << line_of(error.what()) << std::endl;
        }
    }
}
