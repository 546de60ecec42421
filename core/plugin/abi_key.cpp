#include "plugin/abi_key.h"

#include <elf.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

#include "kinome/error.h"

namespace kinome {
namespace {

/// Reads ranges of a file. Throws Error for ranges outside of it.
class FileParts {
 public:
  explicit FileParts(const std::string& path) : stream_(path, std::ios::binary | std::ios::ate) {
    if (!stream_) throw Error(std::string("it can't be read: ") + std::strerror(errno));
    size_ = static_cast<uint64_t>(stream_.tellg());
  }

  uint64_t size() const { return size_; }
  void read(uint64_t offset, void* to, uint64_t bytes) {
    if (offset > size_ || bytes > size_ - offset) throw Error("the ELF file is truncated");
    stream_.seekg(static_cast<std::streamoff>(offset));
    stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes));
    if (!stream_) throw Error("it can't be read");
  }

 private:
  std::ifstream stream_;
  uint64_t size_;
};

Elf64_Ehdr read_header(FileParts& file) {
  Elf64_Ehdr header{};
  if (file.size() < sizeof header) throw Error("it is not an ELF file");
  file.read(0, &header, sizeof header);
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) throw Error("it is not an ELF file");
  if (header.e_ident[EI_CLASS] != ELFCLASS64 || header.e_ident[EI_DATA] != ELFDATA2LSB) {
    throw Error("it was built for a different architecture");
  }
  if (header.e_shentsize != sizeof(Elf64_Shdr) || header.e_shstrndx >= header.e_shnum) {
    throw Error("it has no ELF sections");
  }
  return header;
}

}  // namespace

std::string read_abi_key(const std::string& path) {
  constexpr uint64_t kMaxKeyBytes = 4096;
  FileParts file(path);
  const Elf64_Ehdr header = read_header(file);
  std::vector<Elf64_Shdr> sections(header.e_shnum);
  file.read(header.e_shoff, sections.data(), sections.size() * sizeof(Elf64_Shdr));
  const Elf64_Shdr& names = sections[header.e_shstrndx];
  for (const Elf64_Shdr& section : sections) {
    constexpr char kName[] = "kinome_abi";
    char name[sizeof kName] = {};
    if (section.sh_name > names.sh_size || names.sh_size - section.sh_name < sizeof name) continue;
    file.read(names.sh_offset + section.sh_name, name, sizeof name);
    if (std::memcmp(name, kName, sizeof name) != 0) continue;
    if (section.sh_size > kMaxKeyBytes) throw Error("its section kinome_abi is damaged");
    std::string key(section.sh_size, '\0');
    file.read(section.sh_offset, key.data(), key.size());
    return key.c_str();  // up to its NUL
  }
  throw Error("it has no section kinome_abi: KINOME_PLUGIN is missing");
}

}  // namespace kinome
