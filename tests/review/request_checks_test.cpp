#include "tactile/review/request_checks.hpp"

#include <gtest/gtest.h>

#include <set>

namespace tactile::review {
namespace {

bool is_foreign(const RequestOrigin& from, const std::string& served = "127.0.0.1") {
  return !why_foreign(from, served, 7790, "lab-pc").empty();
}

TEST(RequestChecks, LoopbackNamesWithThePortAreThisHost) {
  for (const char* host : {"127.0.0.1:7790", "localhost:7790", "LOCALHOST:7790", "[::1]:7790"})
    EXPECT_FALSE(is_foreign({.host = host, .origin = "", .sec_fetch_site = ""})) << host;
}

TEST(RequestChecks, AnotherHostOrPortIsForeign) {
  for (const char* host : {"", "127.0.0.1", "127.0.0.1:80", "evil.example:7790", "127.0.0.1.evil.example:7790", "evil.example",
                           "127.0.0.1:7790.evil.example", "10.0.0.1:7790", "localhost:77900"})
    EXPECT_TRUE(is_foreign({.host = host, .origin = "", .sec_fetch_site = ""})) << host;
}

TEST(RequestChecks, AnotherOriginIsForeign) {
  const std::string host = "127.0.0.1:7790";
  EXPECT_FALSE(is_foreign({.host = host, .origin = "http://127.0.0.1:7790", .sec_fetch_site = ""}));
  for (const char* origin : {"null", "http://evil.example", "https://127.0.0.1:7790", "http://127.0.0.1", "http://localhost:7790",
                             "http://127.0.0.1:7790.evil.example"})
    EXPECT_TRUE(is_foreign({.host = host, .origin = origin, .sec_fetch_site = ""})) << origin;
}

TEST(RequestChecks, WhatTheBrowserCallsAnotherSiteIsForeign) {
  const std::string host = "127.0.0.1:7790";
  for (const char* site : {"same-origin", "none"})
    EXPECT_FALSE(is_foreign({.host = host, .origin = "", .sec_fetch_site = site})) << site;
  for (const char* site : {"cross-site", "same-site", "Same-Origin?"})
    EXPECT_TRUE(is_foreign({.host = host, .origin = "", .sec_fetch_site = site})) << site;
}

TEST(RequestChecks, TheServedNameIsThisHostAndNoOther) {
  EXPECT_FALSE(is_foreign({.host = "10.0.0.7:7790", .origin = "", .sec_fetch_site = ""}, "10.0.0.7"));
  EXPECT_TRUE(is_foreign({.host = "10.0.0.8:7790", .origin = "", .sec_fetch_site = ""}, "10.0.0.7"));
}

TEST(RequestChecks, WhereEveryAddressIsServedANameMustBeTheMachines) {
  for (const char* host : {"10.0.0.7:7790", "[fe80::1]:7790", "lab-pc:7790", "Lab-PC:7790"})
    EXPECT_FALSE(is_foreign({.host = host, .origin = "", .sec_fetch_site = ""}, "0.0.0.0")) << host;
  EXPECT_TRUE(is_foreign({.host = "evil.example:7790", .origin = "", .sec_fetch_site = ""}, "0.0.0.0"));
}

TEST(RequestChecks, AReasonIsASentenceThatNamesTheHost) {
  EXPECT_EQ(why_foreign({.host = "evil.example", .origin = "", .sec_fetch_site = ""}, "127.0.0.1", 7790, ""),
            "the request is for the host 'evil.example'; expected the address that 'tactile' printed");
}

TEST(RequestChecks, TokensAreLongAndDiffer) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) tokens.insert(random_token());
  EXPECT_EQ(tokens.size(), 100U);
  for (const std::string& token : tokens) {
    EXPECT_EQ(token.size(), 32U);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
  }
}

TEST(RequestChecks, OnlyTheSameSecretIsTheSame) {
  EXPECT_TRUE(same_secret("0123", "0123"));
  for (const char* given : {"", "0124", "1123", "012", "01234"}) EXPECT_FALSE(same_secret(given, "0123")) << given;
}

TEST(RequestChecks, ACookieIsFoundAmongOthers) {
  EXPECT_EQ(cookie_in("a=1; tactile-7790=abc; b=2", "tactile-7790"), "abc");
  EXPECT_EQ(cookie_in("tactile-7790=abc", "tactile-7790"), "abc");
  EXPECT_EQ(cookie_in("xtactile-7790=abc; tactile-77901=d", "tactile-7790"), "");
  EXPECT_EQ(cookie_in("", "tactile-7790"), "");
}

}  // namespace
}  // namespace tactile::review
