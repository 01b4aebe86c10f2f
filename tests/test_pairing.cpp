// SPDX-License-Identifier: MIT
// Codes, sessions and the certificate of the studio in the network, with a clock that the test
// sets. tests/test_studio_lan.py tests the same from outside.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include <sys/stat.h>

#include <kibori/base/file.h>

#include "apps/studio/certificate.h"
#include "apps/studio/pairing.h"
#include "apps/studio/secret.h"

namespace kibori::studio {
namespace {

using std::chrono::minutes;
using std::chrono::seconds;
using Outcome = Pairing::Outcome;

struct Terminal {
  Pairing pairing;
  std::vector<std::string> codes;
  Pairing::Clock::time_point now = Pairing::Clock::now();
  Terminal() {
    pairing.on_code = [this](const std::string& code) { codes.push_back(code); };
    pairing.offer(now);
  }
  Outcome enter(const std::string& code) { return pairing.enter(code, now).outcome; }
  std::string wrong() const {
    return codes.back().substr(1) + (codes.back()[0] == 'A' ? 'B' : 'A');
  }
};

TEST(Pairing, ACodeIsValidForAFewMinutes) {
  Terminal terminal;
  terminal.now += Pairing::kCodeTime - seconds(1);
  terminal.pairing.offer(terminal.now);
  ASSERT_EQ(terminal.codes.size(), 1u);  // it is still valid
  terminal.now += seconds(1);
  EXPECT_EQ(terminal.enter(terminal.codes[0]), Outcome::expired);
  ASSERT_EQ(terminal.codes.size(), 2u);
  EXPECT_EQ(terminal.enter(terminal.codes[0]), Outcome::wrong);
  terminal.now += Pairing::kCodeTime - seconds(1);
  EXPECT_EQ(terminal.enter(terminal.codes[1]), Outcome::paired);
}

TEST(Pairing, CodesAreRandomAndReadable) {
  Terminal terminal;
  std::set<std::string> different;
  std::set<char> letters;
  for (int i = 0; i < 500; i++) {
    terminal.now += Pairing::kCodeTime;
    terminal.pairing.offer(terminal.now);
    const std::string& code = terminal.codes.back();
    EXPECT_EQ(code.size(), 6u);
    EXPECT_EQ(code.find_first_of("IO01"), code.npos) << code;
    different.insert(code);
    letters.insert(code.begin(), code.end());
  }
  // In one of 8000 runs, two of the 500 codes are equal.
  EXPECT_GE(different.size(), 499u);
  EXPECT_EQ(letters.size(), 32u);
}

TEST(Pairing, WrongCodesMakeEveryoneWait) {
  Terminal terminal;
  const std::string code = terminal.codes[0];
  for (int i = 0; i + 1 < Pairing::kWrongCodes; i++)
    EXPECT_EQ(terminal.enter(terminal.wrong()), Outcome::wrong);
  EXPECT_EQ(terminal.enter(terminal.wrong()), Outcome::wait);
  terminal.now += Pairing::kWait - seconds(1);
  const Pairing::Answer answer = terminal.pairing.enter(code, terminal.now);
  EXPECT_EQ(answer.outcome, Outcome::wait);
  EXPECT_EQ(answer.wait, seconds(1));
  terminal.pairing.offer(terminal.now);
  EXPECT_EQ(terminal.codes.size(), 1u);  // no new code either
  // The old code stays void. The new one works.
  terminal.now += seconds(1);
  EXPECT_EQ(terminal.enter(code), Outcome::expired);
  ASSERT_EQ(terminal.codes.size(), 2u);
  EXPECT_EQ(terminal.enter(terminal.codes[1]), Outcome::paired);
}

TEST(Pairing, GuessesPerHourAreBounded) {
  Terminal terminal;
  int compared = 0;
  for (const auto end = terminal.now + minutes(60); terminal.now < end;
       terminal.now += seconds(1)) {
    const Outcome outcome = terminal.enter("AAAAA1");  // no code contains a 1
    EXPECT_NE(outcome, Outcome::paired);
    compared += outcome == Outcome::wrong;
  }
  EXPECT_LE(compared, 5 * 60);
  EXPECT_GE(compared, 4 * 50);
}

TEST(Pairing, EachDeviceHasItsSession) {
  Terminal terminal;
  const Pairing::Answer first = terminal.pairing.enter(terminal.codes[0], terminal.now);
  EXPECT_EQ(first.session.size(), 64u);
  terminal.pairing.offer(terminal.now);
  const Pairing::Answer second = terminal.pairing.enter(terminal.codes[1], terminal.now);
  EXPECT_NE(first.session, second.session);
  for (const Pairing::Answer& answer : {first, second})
    EXPECT_TRUE(terminal.pairing.is_session(answer.session));
  for (const std::string& other : {std::string(), first.session.substr(1), first.session + "0",
                                   random_hex(), std::string("0")})
    EXPECT_FALSE(terminal.pairing.is_session(other));
}

TEST(Pairing, SecretsAreCompared) {
  EXPECT_TRUE(same_secret("", ""));
  EXPECT_TRUE(same_secret("abc", "abc"));
  for (const char* const other : {"", "ab", "abcd", "abd", "xbc", "ABC"})
    EXPECT_FALSE(same_secret("abc", other)) << other;
}

class CertificateFile : public testing::Test {
 protected:
  const std::shared_ptr<TemporaryFolder> folder_ = TemporaryFolder::make().value();
  const std::filesystem::path file_ = folder_->path() / "new" / "lan.pem";
  const std::vector<std::string> addresses_{"192.168.1.5", "fd00::5"};
  const std::time_t now_ = 1'800'000'000;
  Certificate keep(const std::vector<std::string>& addresses, std::time_t now) const {
    Result<Certificate> kept = keep_certificate(file_, addresses, now);
    EXPECT_TRUE(kept.ok()) << kept.error();
    struct stat status {};
    EXPECT_EQ(stat(file_.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600u);
    return std::move(kept).value();
  }
};

TEST_F(CertificateFile, IsKeptUntilItExpires) {
  constexpr std::time_t kDay = 24 * 60 * 60;
  const Certificate first = keep(addresses_, now_);
  EXPECT_FALSE(first.made.empty());
  EXPECT_EQ(first.fingerprint.size(), 32u * 3 - 1);
  for (const std::time_t later : {std::time_t{0}, 100 * kDay, 395 * kDay}) {
    const Certificate again = keep(addresses_, now_ + later);
    EXPECT_EQ(again.fingerprint, first.fingerprint) << later;
    EXPECT_EQ(again.pem, first.pem);
    EXPECT_TRUE(again.made.empty()) << again.made;
  }
  EXPECT_EQ(keep({"fd00::5"}, now_).fingerprint, first.fingerprint);  // it names more
  const Certificate renewed = keep(addresses_, now_ + 396 * kDay);
  EXPECT_NE(renewed.fingerprint, first.fingerprint);
  EXPECT_NE(renewed.made.find("expires"), std::string::npos) << renewed.made;
  // Made by a clock that was wrong.
  EXPECT_NE(keep(addresses_, now_).made.find("not valid yet"), std::string::npos);
}

TEST_F(CertificateFile, IsRemadeForOtherAddresses) {
  const Certificate first = keep(addresses_, now_);
  const Certificate moved = keep({"192.168.1.5", "10.0.0.7"}, now_);
  EXPECT_NE(moved.fingerprint, first.fingerprint);
  EXPECT_NE(moved.made.find("10.0.0.7"), std::string::npos) << moved.made;
}

TEST_F(CertificateFile, IsRemadeIfItsKeyIsNotPrivateOrIsDamaged) {
  const Certificate first = keep(addresses_, now_);
  std::filesystem::permissions(file_, std::filesystem::perms(0604));
  const Certificate second = keep(addresses_, now_);
  EXPECT_NE(second.made.find("other users"), std::string::npos) << second.made;
  EXPECT_NE(second.fingerprint, first.fingerprint);
  // The key of one certificate with the text of the other.
  const auto text = [](const Certificate& c) {
    return c.pem.substr(c.pem.find("-----BEGIN CERT"));
  };
  for (const std::string& damaged :
       {std::string(), std::string("x"), second.pem.substr(0, 300), text(second),
        second.pem.substr(0, second.pem.find("-----BEGIN CERT")) + text(first)}) {
    std::ofstream(file_, std::ios::trunc) << damaged;
    const Certificate made = keep(addresses_, now_);
    EXPECT_NE(made.made.find("damaged"), std::string::npos) << made.made;
    EXPECT_NE(made.fingerprint, second.fingerprint);
  }
  // A link to a file of someone else is not followed.
  const std::filesystem::path other = folder_->path() / "other";
  std::ofstream(other) << second.pem;
  std::filesystem::remove(file_);
  std::filesystem::create_symlink(other, file_);
  EXPECT_FALSE(keep(addresses_, now_).made.empty());
  EXPECT_FALSE(std::filesystem::is_symlink(file_));
  EXPECT_TRUE(std::filesystem::is_regular_file(other));
}

TEST_F(CertificateFile, IsNotStoredWhereNothingCanBe) {
  std::ofstream(folder_->path() / "new") << "a file in the place of the folder";
  const Result<Certificate> kept = keep_certificate(file_, addresses_, now_);
  ASSERT_FALSE(kept.ok());
  EXPECT_NE(kept.error().find("lan.pem"), std::string::npos) << kept.error();
}

}  // namespace
}  // namespace kibori::studio
