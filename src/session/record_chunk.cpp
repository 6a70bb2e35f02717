#include "record_chunk.h"

#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <limits>
#include <new>

#include "raven2_trainer/core/bytes.h"
#include "record_columns.h"
#include "tick_formulas.h"

namespace raven2_trainer::session {
namespace {

constexpr std::size_t kMostRecords = 16384;
constexpr int kLevel = 1;  // of zstd: 3 is 3.6 % smaller, for 0.8 us a tick (measured)

/** Bytes one after the other. Their memory only grows, and is not set to zero again. */
class Contents {
 public:
  void clear() noexcept { size_ = 0; }
  const std::uint8_t* data() const noexcept { return bytes_.data(); }
  std::size_t size() const noexcept { return size_; }

  /** @return where the next `size` bytes belong, until the next call. */
  std::uint8_t* next(std::size_t size) {
    if (bytes_.size() < size_ + size) bytes_.resize(std::max(size_ + size, kMaxChunkRecords));
    size_ += size;
    return bytes_.data() + (size_ - size);
  }

  template <typename T>
  void append(T value) {
    std::memcpy(next(sizeof(T)), &value, sizeof(T));
  }

  void append(const std::vector<std::uint8_t>& bytes) { std::copy(bytes.begin(), bytes.end(), next(bytes.size())); }

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t size_{0};
};

/** Every kind of record but these says first in which physics tick it belongs. */
bool beginsWithTick(const FrameHeader& header) noexcept {
  return header.length >= sizeof(Tick) && header.type != RecordType::kCounts && header.type != RecordType::kRecovery;
}

struct ZstdDelete {
  void operator()(ZSTD_CCtx* context) const noexcept { ZSTD_freeCCtx(context); }
};

}  // namespace

struct ChunkPacker::Impl {
  /** Records of one type, version and length. */
  struct Group {
    FrameHeader like;
    std::vector<std::uint8_t> forms;
    std::vector<std::uint8_t> rows;  ///< payloads, one after the other
    std::size_t count{0};
    std::uint8_t number{0};  ///< in this chunk
  };

  Group& groupOf(const FrameHeader& header) {
    const auto is_same = [&](const Group& group) {
      return group.like.type == header.type && group.like.version == header.version &&
             group.like.length == header.length;
    };
    const auto found = std::find_if(groups.begin(), groups.end(), is_same);
    if (found != groups.end()) return *found;
    Group group;
    group.like = header;
    group.forms = columnForms(header.type, header.length);
    const auto one_each_tick = static_cast<std::size_t>(kMaxChunkTicks) * header.length;
    group.rows.reserve(std::min(kMaxChunkRecords, one_each_tick));  // so that a late batch takes no memory
    groups.push_back(std::move(group));
    return groups.back();
  }

  /** Widens the span of the chunk by the record's tick. @return false if it would be too long. */
  bool fits(const FrameHeader& header, const std::uint8_t* payload) {
    if (!beginsWithTick(header)) return true;
    Tick tick = 0;
    std::memcpy(&tick, payload, sizeof(tick));
    const Tick first_then = std::min(first_tick, tick), last_then = std::max(last_tick, tick);
    // Unsigned, because ticks of a log may be any numbers.
    const auto span = static_cast<std::uint64_t>(last_then) - static_cast<std::uint64_t>(first_then);
    if (span >= static_cast<std::uint64_t>(kMaxChunkTicks) && !order.empty()) return false;
    first_tick = first_then;
    last_tick = last_then;
    return true;
  }

  /** Takes records up to the chunk's limit. @return [bytes] taken. */
  std::size_t take(const std::uint8_t* frames, std::size_t size) {
    std::size_t at = 0;
    while (at < size && at < kMaxChunkRecords) {
      const FrameHeader header = decodeFrameHeader(frames + at);
      if (!fits(header, frames + at + kFrameHeaderSize)) break;
      Group& group = groupOf(header);
      if (group.count == 0) {
        group.number = static_cast<std::uint8_t>(used.size());
        used.push_back(&group);
      }
      if (order.empty()) first = header.number;
      order.push_back(group.number);
      const std::uint8_t* payload = frames + at + kFrameHeaderSize;
      group.rows.insert(group.rows.end(), payload, payload + header.length);
      ++group.count;
      at += kFrameHeaderSize + header.length + kCrcSize;
    }
    return at;
  }

  void writeContents() {
    contents.clear();
    contents.append(static_cast<std::uint32_t>(order.size()));
    contents.append(static_cast<std::uint32_t>(used.size()));
    for (const Group* group : used) {
      contents.append(static_cast<std::uint16_t>(group->like.type));
      contents.append(group->like.version);
      contents.append(static_cast<std::uint32_t>(group->count));
      contents.append(static_cast<std::uint32_t>(group->forms.size()));
    }
    contents.append(order);
    for (const Group* group : used)
      writeGroup(*group);
  }

  /** Makes the group's formulas. @return for each column their results, or null. */
  std::vector<const double*> predict(const Group& group, const std::vector<std::size_t>& offsets) {
    std::vector<const double*> predicted(group.forms.size());
    used_formulas.clear();
    const bool is_other_version = group.forms.size() == group.like.length;  // its numbers are single bytes
    if (!formulas || group.like.type != RecordType::kTick || is_other_version || group.count > kMostFormulaRows) {
      return predicted;
    }
    const RecordView records{group.rows.data(), group.like.length, group.count, offsets.data()};
    used_formulas = formulas->of(records);
    results.resize(used_formulas.size());
    for (std::size_t f = 0; f < used_formulas.size(); ++f) {
      evaluate(used_formulas[f], records, &results[f]);
      forResults(used_formulas[f], [&](std::size_t column, std::size_t place) {
        if (predicted[column] == nullptr) predicted[column] = &results[f][place * group.count];
      });
    }
    return predicted;
  }

  void writeGroup(const Group& group) {
    const std::vector<std::size_t> offsets = offsetsOf(group.forms);
    const std::vector<const double*> predicted = predict(group, offsets);
    columns.clear();
    choices.clear();
    orders.clear();
    for (std::size_t c = 0; c < group.forms.size(); ++c) {
      columns.push_back(
          {ColumnForm(group.forms[c]), group.rows.data() + offsets[c], group.like.length, group.count, predicted[c]});
      choices.push_back(coder.choose(columns[c]));
      orders.push_back(choices[c].code);
    }
    contents.append(group.forms);
    contents.append(orders);
    formula_bytes.assign(1, static_cast<std::uint8_t>(used_formulas.size()));
    for (const Formula& formula : used_formulas)
      formula.append(&formula_bytes);
    contents.append(formula_bytes);
    std::uint8_t* data = contents.next(group.rows.size());
    const std::vector<Place> places = placesOf(group.forms, orders, group.count);
    for (std::size_t c = 0; c < places.size(); ++c)
      coder.encode(columns[c], choices[c], data + places[c].plane, places[c].stride);
  }

  void writeChunk(std::vector<std::uint8_t>* chunks) {
    const std::size_t bound = ZSTD_compressBound(contents.size());
    const std::size_t room = kFrameHeaderSize + kChunkSpanSize + bound + kCrcSize;
    if (chunk.size() < room) chunk.resize(room);
    std::uint8_t* frame = chunk.data();
    ByteWriter span(frame + kFrameHeaderSize, kChunkSpanSize);
    span.put(first_tick);
    span.put(last_tick);
    const std::size_t size = ZSTD_compressCCtx(zstd.get(), frame + kFrameHeaderSize + kChunkSpanSize, bound,
                                               contents.data(), contents.size(), kLevel);
    if (ZSTD_isError(size) != 0) throw std::bad_alloc();  // with room for any result, memory is all it can lack
    const std::size_t length = kChunkSpanSize + size;
    encodeFrameHeader({kMagic, RecordType::kChunk, kChunkVersion, static_cast<std::uint32_t>(length), first}, frame);
    const std::uint32_t crc = crc32Of(frame, kFrameHeaderSize + length);
    std::memcpy(frame + kFrameHeaderSize + length, &crc, kCrcSize);
    chunks->insert(chunks->end(), frame, frame + kFrameHeaderSize + length + kCrcSize);
  }

  /** The groups keep their memory for the next chunk. */
  void clear() {
    order.clear();
    used.clear();
    first_tick = std::numeric_limits<Tick>::max();
    last_tick = std::numeric_limits<Tick>::min();
    for (Group& group : groups) {
      group.rows.clear();
      group.count = 0;
    }
  }

  std::unique_ptr<ZSTD_CCtx, ZstdDelete> zstd{ZSTD_createCCtx()};
  std::deque<Group> groups;  // does not move its elements
  std::vector<Group*> used;  // in this chunk
  std::optional<TickFormulas> formulas;
  std::vector<Formula> used_formulas;        // of the group that is written
  std::vector<std::vector<double>> results;  // of each
  std::vector<std::uint8_t> order, orders, formula_bytes;
  std::vector<ColumnView> columns;  // of the group that is written
  std::vector<ColumnChoice> choices;
  Contents contents;
  std::vector<std::uint8_t> chunk;  // only grows
  std::uint64_t first{0};           // number of the first record
  Tick first_tick{0}, last_tick{0};
  ColumnCoder coder;
};

ChunkPacker::ChunkPacker(const std::optional<TickConstants>& constants) : impl_(std::make_unique<Impl>()) {
  if (!impl_->zstd) throw std::bad_alloc();
  if (constants) impl_->formulas.emplace(*constants);
  // More than there are in a chunk of a session, again for late batches.
  impl_->order.reserve(kMostRecords);
  impl_->coder.reserve(kMostRecords);
}

ChunkPacker::~ChunkPacker() = default;

void ChunkPacker::pack(const std::uint8_t* frames, std::size_t size, std::vector<std::uint8_t>* chunks) {
  Impl& s = *impl_;
  for (std::size_t at = 0; at < size;) {
    s.clear();
    at += s.take(frames + at, size - at);
    s.writeContents();
    s.writeChunk(chunks);
  }
}

struct ChunkReader::Group {
  FrameHeader like{kMagic, {}, {}, 0, 0};
  std::uint32_t count{};    ///< records
  std::uint32_t columns{};  ///< numbers in a record
  std::size_t taken{0};
  std::vector<std::uint8_t> rows;  ///< payloads, one after the other
  std::vector<std::uint8_t> forms, orders;
  std::vector<std::size_t> offsets;
  std::vector<Formula> formulas;

  /** @return false for what no writer makes. */
  bool readHeader(ByteReader* in) {
    like.type = static_cast<RecordType>(in->get<std::uint16_t>());
    like.version = in->get<std::uint16_t>();
    count = in->get<std::uint32_t>();
    columns = in->get<std::uint32_t>();
    return !in->underflow() && count > 0 && columns > 0 && like.type != RecordType::kHeader &&
           like.type != RecordType::kChunk;
  }

  bool readCodings(ByteReader* in) {
    if (columns > in->left() / 2) return false;
    forms.resize(columns);
    orders.resize(columns);
    in->getBytes(forms.data(), columns);
    in->getBytes(orders.data(), columns);
    for (std::size_t c = 0; c < columns; ++c) {
      const ColumnForm form(forms[c]);
      const ColumnCoding coding(orders[c]);
      if (!form.isValid() || coding.order() > kMostDifferences) return false;
      if (coding.hasFormula() && !form.isFloat()) return false;
    }
    offsets = offsetsOf(forms);
    return offsets.back() <= kMaxPayload;
  }

  bool readFormulas(ByteReader* in) {
    formulas.resize(in->get<std::uint8_t>());
    if (in->underflow() || formulas.size() > kMostFormulas || (!formulas.empty() && count > kMostFormulaRows)) {
      return false;
    }
    for (Formula& formula : formulas) {
      if (!formula.read(in) || !fits(formula)) return false;
    }
    const auto is_robot = [](const Formula& formula) { return formula.kind == FormulaKind::kRobot; };
    return std::count_if(formulas.begin(), formulas.end(), is_robot) <= 1;
  }

  /** Whether its columns are numbers of the record: doubles, but for the robot's cycle. */
  bool fits(const Formula& formula) const {
    const auto& blocks = traitsOf(formula.kind)->blocks;
    for (std::size_t b = 0; b < formula.columns.size(); ++b) {
      const std::uint8_t wanted = blocks[b].width == 1 ? 8 : 8 | ColumnForm::kFloatBit;
      for (std::size_t c = formula.columns[b]; c < formula.columns[b] + std::size_t{blocks[b].width}; ++c) {
        if (c >= columns || forms[c] != wanted) return false;
      }
    }
    return true;
  }

  /** Adds the formulas' results. @return false if one of their inputs is still missing, or a column has no formula. */
  bool addFormulas() {
    std::vector<bool> is_known(columns);
    for (std::size_t c = 0; c < columns; ++c)
      is_known[c] = !ColumnCoding(orders[c]).hasFormula();
    const RecordView records{rows.data(), like.length, count, offsets.data()};
    std::vector<double> results;
    for (const Formula& formula : formulas) {
      const auto& blocks = traitsOf(formula.kind)->blocks;
      for (std::size_t b = 0; b < formula.columns.size(); ++b) {
        for (std::size_t i = 0; !blocks[b].is_result && i < blocks[b].width; ++i) {
          if (!is_known[formula.columns[b] + i]) return false;
        }
      }
      evaluate(formula, records, &results);
      forResults(formula, [&](std::size_t c, std::size_t place) {
        if (!is_known[c]) addFormula(&results[place * count], count, rows.data() + offsets[c], like.length);
        is_known[c] = true;
      });
    }
    return std::find(is_known.begin(), is_known.end(), false) == is_known.end();
  }

  bool readRows(ByteReader* in, ColumnCoder* coder, bool has_formulas) {
    if (!readCodings(in) || (has_formulas && !readFormulas(in))) return false;
    const std::size_t length = offsets.back();
    if (count > in->left() / length) return false;
    like.length = static_cast<std::uint32_t>(length);
    std::vector<std::uint8_t> planes(count * length);
    in->getBytes(planes.data(), planes.size());
    rows.resize(planes.size());
    const std::vector<Place> places = placesOf(forms, orders, count);
    for (std::size_t c = 0; c < places.size(); ++c) {
      coder->decode(ColumnForm(forms[c]), orders[c], planes.data() + places[c].plane, places[c].stride, count,
                    rows.data() + offsets[c], length);
    }
    return addFormulas();
  }
};

ChunkReader::ChunkReader() = default;
ChunkReader::~ChunkReader() = default;

bool ChunkReader::mayBe(const std::uint8_t* payload, std::size_t size) noexcept {
  std::uint32_t magic = 0;
  if (size < kChunkSpanSize + sizeof(magic)) return false;
  std::memcpy(&magic, payload + kChunkSpanSize, sizeof(magic));
  return magic == ZSTD_MAGICNUMBER;
}

bool ChunkReader::open(const FrameHeader& header, const std::uint8_t* payload) {
  groups_.clear();
  order_.clear();
  next_ = 0;
  number_ = header.number;
  if (!mayBe(payload, header.length)) return false;
  const std::uint8_t* compressed = payload + kChunkSpanSize;
  const std::size_t compressed_size = header.length - kChunkSpanSize;
  const unsigned long long size = ZSTD_getFrameContentSize(compressed, compressed_size);
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR || size > kMaxChunkContents) return false;
  contents_.resize(size);
  const std::size_t got = ZSTD_decompress(contents_.data(), contents_.size(), compressed, compressed_size);
  if (got == contents_.size() && readContents(header.version > 1)) return true;
  groups_.clear();
  order_.clear();
  return false;
}

/** Whether every record has its group, and every group its records. */
bool ChunkReader::isComplete() const {
  std::vector<std::uint32_t> counts(groups_.size());
  for (const std::uint8_t group : order_) {
    if (group >= counts.size()) return false;
    ++counts[group];
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] != groups_[i].count) return false;
  }
  return true;
}

bool ChunkReader::readContents(bool has_formulas) {
  ByteReader in(contents_.data(), contents_.size());
  const auto records = in.get<std::uint32_t>();
  const auto groups = in.get<std::uint32_t>();
  if (in.underflow() || records == 0 || groups > std::numeric_limits<std::uint8_t>::max()) return false;
  groups_.resize(groups);
  for (Group& group : groups_) {
    if (!group.readHeader(&in)) return false;
  }
  if (records > in.left()) return false;
  order_.resize(records);
  in.getBytes(order_.data(), records);
  if (!isComplete()) return false;
  for (Group& group : groups_) {
    if (!group.readRows(&in, &coder_, has_formulas)) return false;
  }
  return in.left() == 0;
}

bool ChunkReader::next(FrameHeader* header, const std::uint8_t** payload) {
  if (!hasMore()) return false;
  Group& group = groups_[order_[next_++]];
  *header = group.like;
  header->number = number_++;
  *payload = group.rows.data() + group.taken++ * group.like.length;
  return true;
}

}  // namespace raven2_trainer::session
