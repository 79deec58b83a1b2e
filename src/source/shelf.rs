//! What files were decoded to, kept while there is room.

use std::any::{Any, TypeId};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What was decoded from files, by type, content and way of decoding.
#[derive(Debug)]
pub struct Shelf(Mutex<Stock>);

type Key = (TypeId, Vec<u8>);
type Slot = Arc<Mutex<Option<Arc<dyn Any + Send + Sync>>>>;

#[derive(Debug)]
struct Stock {
    items: BTreeMap<Key, Item>,
    bytes: u64,
    limit: u64,
    clock: u64,
}

#[derive(Debug)]
struct Item {
    slot: Slot,
    /// 0 while it is being made.
    bytes: u64,
    used: u64,
}

impl Default for Shelf {
    /// A shelf without a limit.
    fn default() -> Self {
        Self(Mutex::new(Stock { items: BTreeMap::new(), bytes: 0, limit: u64::MAX, clock: 0 }))
    }
}

impl Shelf {
    fn stock(&self) -> MutexGuard<'_, Stock> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Bytes that stand on it.
    pub fn bytes(&self) -> u64 {
        self.stock().bytes
    }

    /// Sets how many bytes may stand on it, and drops what was not used for longest beyond it.
    pub fn limit(&self, bytes: u64) {
        let mut stock = self.stock();
        stock.limit = bytes;
        stock.shrink();
    }

    /// What stands under a key, made where nothing does; who asks while it is being made waits.
    ///
    /// # Errors
    /// Those of `make`.
    pub(super) fn get<T: Send + Sync + 'static, E>(
        &self,
        key: Vec<u8>,
        make: impl FnOnce() -> Result<(T, u64), E>,
    ) -> Result<Arc<T>, E> {
        let key = (TypeId::of::<T>(), key);
        let slot = self.stock().slot(&key);
        let mut held = slot.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = held.clone().and_then(|any| any.downcast::<T>().ok()) {
            return Ok(found);
        }
        match make() {
            Ok((made, bytes)) => {
                let made = Arc::new(made);
                *held = Some(made.clone());
                self.stock().enter(&key, &slot, bytes);
                Ok(made)
            }
            Err(e) => {
                self.stock().forget(&key, &slot);
                Err(e)
            }
        }
    }
}

impl Stock {
    fn slot(&mut self, key: &Key) -> Slot {
        self.clock += 1;
        let fresh = || Item { slot: Slot::default(), bytes: 0, used: 0 };
        let item = self.items.entry(key.clone()).or_insert_with(fresh);
        item.used = self.clock;
        item.slot.clone()
    }

    /// Enters what was made in a slot; one that was dropped meanwhile stays so.
    fn enter(&mut self, key: &Key, slot: &Slot, bytes: u64) {
        let bytes = bytes.max(1);
        if let Some(item) = self.items.get_mut(key).filter(|i| Arc::ptr_eq(&i.slot, slot)) {
            self.bytes += bytes - item.bytes;
            item.bytes = bytes;
        }
        self.shrink();
    }

    fn forget(&mut self, key: &Key, slot: &Slot) {
        if self.items.get(key).is_some_and(|i| Arc::ptr_eq(&i.slot, slot) && i.bytes == 0) {
            self.items.remove(key);
        }
    }

    /// Drops what was not used for longest until the rest fits; what is being made stays.
    fn shrink(&mut self) {
        while self.bytes > self.limit {
            let made = self.items.iter().filter(|(_, i)| i.bytes > 0);
            let Some(oldest) = made.min_by_key(|(_, i)| i.used).map(|(k, _)| k.clone()) else { return };
            if let Some(item) = self.items.remove(&oldest) {
                self.bytes -= item.bytes;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn put(shelf: &Shelf, key: u8, bytes: u64) -> bool {
        let mut made = false;
        let make = || {
            made = true;
            Ok::<_, ()>((key, bytes))
        };
        assert_eq!(*shelf.get(vec![key], make).expect("makes"), key);
        made
    }

    #[test]
    fn makes_once_and_drops_what_was_not_used_for_longest() {
        let shelf = Shelf::default();
        assert!(put(&shelf, 1, 40) && put(&shelf, 2, 40) && !put(&shelf, 1, 40));
        shelf.limit(100);
        assert!(put(&shelf, 3, 40) && shelf.bytes() == 80);
        assert!(!put(&shelf, 1, 40) && put(&shelf, 2, 40));
        // What is larger than the shelf is made and not kept.
        assert!(put(&shelf, 4, 1000) && put(&shelf, 4, 1000) && shelf.bytes() == 0);
        shelf.limit(0);
        assert!(put(&shelf, 1, 1) && put(&shelf, 1, 1));
    }

    #[test]
    fn forgets_what_could_not_be_made() {
        let shelf = Shelf::default();
        assert_eq!(shelf.get(vec![1], || Err::<(u8, u64), _>("no")).expect_err("fails"), "no");
        assert!(shelf.stock().items.is_empty());
        assert!(put(&shelf, 1, 7) && shelf.bytes() == 7);
    }

    #[test]
    fn waits_for_what_is_being_made() {
        let (shelf, count) = (Shelf::default(), std::sync::atomic::AtomicU32::new(0));
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    let make = || {
                        std::thread::sleep(std::time::Duration::from_millis(20));
                        Ok::<_, ()>((count.fetch_add(1, std::sync::atomic::Ordering::SeqCst), 1))
                    };
                    assert_eq!(*shelf.get(Vec::new(), make).expect("makes"), 0);
                });
            }
        });
    }
}
