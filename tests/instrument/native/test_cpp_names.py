"""What a demangled symbol is called in its source."""

import pytest

from tracerisk.instrument.native.cpp_names import (
    is_lambda,
    is_mangled_of_library,
    is_of_library,
    lambda_owner,
    source_name,
)

NAMES = {
    "main": "main",
    "Cell::home()": "Cell::home",
    "Cell::swing(double, double)": "Cell::swing",
    "Cell::at() const": "Cell::at",
    "Cell::take() &&": "Cell::take",
    "void wave<double>(double)": "wave",
    "std::vector<int, std::allocator<int> > cells::plan<int>(int)": "cells::plan",
    "Queue<double>::Queue(int)": "Queue::Queue",
    "Queue<std::pair<int, (Kind)3> >::~Queue()": "Queue::~Queue",
    "(anonymous namespace)::hidden(int)": "hidden",
    "arm::(anonymous namespace)::Cell::go()": "arm::Cell::go",
    "arm::v1::go()": "arm::v1::go",
    "main::{lambda(double)#1}::operator()(double) const": "main",
    "auto Cell::go()::{lambda(auto:1)#2}::operator()<int>(int) const": "Cell::go",
    "Cell::go(int)::{lambda()#1}::operator()() const::{lambda()#1}::operator()() const": "Cell::go",
    "arm::{lambda()#1}::operator()() const": "arm",
    "main::$_0::operator()() const": "main",
    "Cell::swing(double) const::Local::run(int)": "Cell::swing::Local::run",
    "Cell::operator()(double)": "Cell::operator()",
    "Cell::operator[](int) const": "Cell::operator[]",
    "Cell::operator<<(int)": "Cell::operator<<",
    "operator<<(std::ostream&, Cell const&)": "operator<<",
    "bool operator< <int>(Box<int> const&, Box<int> const&)": "operator<",
    "bool operator==<int>(Box<int> const&, Box<int> const&)": "operator==",
    "Box<int>& operator<<<int>(Box<int>&, int)": "operator<<",
    "Cell::operator->() const": "Cell::operator->",
    "Box<int>::operator+(Box<int> const&) const": "Box::operator+",
    "Box<(1>2)>::operator>(int)": "Box::operator>",
    "Cell::operator bool() const": "Cell::operator_bool",
    "Cell::operator double() const": "Cell::operator_double",
    "Cell::operator std::vector<int, std::allocator<int> >()": "Cell::operator_std::vector",
    "Cell::operator new(unsigned long)": "Cell::operatornew",
    "Cell::operator delete[](void*)": "Cell::operatordelete[]",
    'operator"" _deg(long double)': 'operator""_deg',
    "Cell::operator std::__cxx11::basic_string<char, std::char_traits<char>, "
    "std::allocator<char> >() const": "Cell::operator_std::string",
    "name[abi:cxx11]()": "name",
    "Cell::home() [clone .constprop.0]": "Cell::home",
    "Cell::home() [clone .cold]": "Cell::home",
    "Cell::on(boost::shared_ptr<std_msgs::String_<std::allocator<void> > const> const&)": "Cell::on",
    "std::function<void (int)> make<int>(std::function<void (int)>)": "make",
    "decltype (auto) pick<int>(int)": "pick",
}


@pytest.mark.parametrize("symbol", NAMES)
def test_a_symbol_has_the_name_of_its_source(symbol):
    assert source_name(symbol) == NAMES[symbol]


@pytest.mark.parametrize(
    "symbol",
    [
        "void ros::Publisher::publish<std_msgs::String>(std_msgs::String const&) const",
        "actionlib::SimpleActionClient<control_msgs::X>::sendGoal(int)",
        "boost::detail::thread_data<main::{lambda()#1}>::run()",
        "std::_Function_handler<void (), main::{lambda()#1}>::_M_invoke(std::_Any_data const&)",
        "_start",
        "_GLOBAL__sub_I_cell",
        "__cxx_global_var_init",
    ],
)
def test_a_symbol_of_a_library_is_none_of_the_controller(symbol):
    assert is_of_library(source_name(symbol))


@pytest.mark.parametrize("name", ["main", "Cell::home", "rosie::go", "_home", "stdx::go"])
def test_other_names_are_those_of_the_controller(name):
    assert not is_of_library(name)


OWNERS = {
    "std::thread::_Invoker<std::tuple<main::{lambda()#1}> > >::_M_run()": "main",
    "__invoke_impl<void, main(int, char**)::<lambda()> >": "main",
    "void run<arm::Cell<int>::go(int, int) const::{lambda()#2}>(int)": "arm::Cell::go",
    "auto Cell::go()::{lambda(auto:1)#2}::operator()<int>(int) const": "Cell::go",
    "main::$_0::operator()() const": "main",
    "Cell::go()": None,
}


@pytest.mark.parametrize("symbol", OWNERS)
def test_a_lambda_belongs_to_the_function_that_holds_it(symbol):
    assert lambda_owner(symbol) == OWNERS[symbol]


def test_a_template_of_a_lambda_is_none():
    assert is_lambda("main::{lambda()#1}::operator()() const")
    assert is_lambda("Cell<int>::go()::$_1::operator()() const")
    assert not is_lambda("void run<main::{lambda()#1}>(int)")
    assert not is_lambda("void run<main::{lambda(int)#1}>(main::{lambda(int)#1})")


@pytest.mark.parametrize(
    ("symbol", "is_library"),
    [
        ("_ZN6rclcpp4Node4initEv", True),
        ("_ZNK6rclcpp4Node8get_nameEv", True),
        ("_ZN13rclcpp_action6ClientIiE4sendEv", True),
        ("_ZNSt6vectorIiSaIiEE9push_backERKi", True),
        ("_ZSt8__invokeIRFvvEJEEvv", True),
        ("_ZZN6rclcpp4spinEvENKUlvE_clEv", True),
        ("_ZNSs6appendEPKc", True),
        ("_ZN4Cell5swingEd", False),
        ("_ZN7rclcppX4NodeC1Ev", False),
        ("_ZZN4Cell4homeEvENKUlvE_clEv", False),
        ("_Z6rclcppv", False),
        ("main", False),
    ],
)
def test_a_mangled_name_of_a_library_is_known_by_its_first_scope(symbol, is_library):
    assert is_mangled_of_library(symbol) == is_library
